"""A small set of runs for the effects to look at, and what they would do to the sockets."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from eaclutch.physics.effect import Effect, Inputs
from eaclutch.physics.effects import EFFECTS
from eaclutch.physics.sockets import Sockets
from eaclutch.records import Bench, RunConditions

PARAMETERS = {
    "kappa_static": 54.2, "kappa_infinity": 4.0, "relaxation_time": 2.82e-6, "cole_cole_exponent": 0.562,
    "stiffness": 18018.0, "film_static": 0.188, "film_kinetic": 0.154, "base_static": 0.281, "base_kinetic": 0.173,
    "film_thickness": 24e-6,
}  # fmt: skip


@pytest.fixture
def inputs() -> Inputs:
    """Four runs: 300 V 1 kHz 2 mm, 300 V DC 2 mm, 150 V 10 Hz 4 mm in the second session, no voltage."""
    conditions = RunConditions(
        run=("a", "b", "c", "d"),
        session=("s1", "s1", "s2", "s2"),
        condition=("a", "b", "c", "d"),
        substrate=("brass",) * 4,
        voltage=np.array([300.0, 300.0, 150.0, 0.0]),
        frequency=np.array([1000.0, 0.1, 10.0, 1000.0]),
        width=np.array([2e-3, 2e-3, 4e-3, 2e-3]),
        thickness=np.array([2e-3, 2e-3, 2e-3, 2e-3]),
        friction_before=np.array([0.1, 0.1, 0.2, 0.1]),
        switch_off_force=np.full(4, np.nan),
        drive_duration=np.array([3.0005, 3.0, 3.05, 3.0]),
        dwell=np.array([0.0005, 0.0, 0.05, 0.0]),
        run_order=np.array([0.0, 1.0, 0.0, 1.0]),
    )
    return Inputs(
        bench=Bench("bench"),
        conditions=conditions,
        parameters={name: np.asarray(value) for name, value in PARAMETERS.items()},
        preload=np.array([0.2, 0.2, 0.5, 0.2]),
        area=1.5e-3 * conditions.width,
        film_mass=np.array([4.7e-6, 4.7e-6, 9.4e-6, 4.7e-6]),
        substrate_mass=np.array([4.0e-3, 4.0e-3, 8.0e-3, 4.0e-3]),
        capacitance=np.array([35e-12, 35e-12, 70e-12, 35e-12]),
        session_index=np.array([0, 0, 1, 1]),
    )


@pytest.fixture
def fill(inputs: Inputs) -> Callable[..., Sockets]:
    """``fill(name, sockets=Sockets(), **values)``: the sockets after one effect; what is left out has its default."""

    def run(name: str, sockets: Sockets | None = None, **values: float | np.ndarray) -> Sockets:
        effect = EFFECTS[name]
        unknown = set(values) - {parameter.name for parameter in effect.parameters}
        assert not unknown
        return effect.apply(sockets or Sockets(), inputs, complete(effect, values))

    return run


def complete(effect: Effect, values: Mapping[str, float | np.ndarray]) -> dict[str, np.ndarray]:
    """Arrays for every parameter of the effect: the given values, else the defaults."""
    return {p.name: np.asarray(values.get(p.name, p.default), dtype=float) for p in effect.parameters}
