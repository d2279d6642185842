"""Runs and a model for the physics tests."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, RunConditions, Substrate

BENCH = Bench(name="test", substrates={"brass": Substrate(density=8049.0)})


def make_runs(**given: object) -> RunConditions:
    """Runs from arrays or scalars that broadcast; what is not given is a 2 mm strip at 300 V, 1 kHz."""
    defaults: dict[str, object] = {
        "voltage": 300.0, "frequency": 1000.0, "width": 2e-3, "thickness": 2e-3, "friction_before": 0.15,
        "switch_off_force": np.nan, "drive_duration": 3.0, "dwell": 0.0, "run_order": 0.0,
    }  # fmt: skip
    arrays = np.broadcast_arrays(*[np.atleast_1d(np.asarray(v, float)) for v in (defaults | given).values()])
    n = arrays[0].size
    names = tuple(f"r{i}" for i in range(n))
    return RunConditions(
        run=names, session=("s",) * n, condition=names, substrate=("brass",) * n,
        **dict(zip(defaults, arrays, strict=True))
    )  # fmt: skip


@pytest.fixture(scope="session")
def runs() -> Callable[..., RunConditions]:
    return make_runs


@pytest.fixture(scope="session")
def model() -> ClutchModel:
    return ClutchModel(BENCH)


@pytest.fixture(scope="session")
def bench() -> Bench:
    return BENCH
