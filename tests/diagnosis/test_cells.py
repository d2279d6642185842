"""The ruler that a gap is measured with."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from eaclutch.diagnosis.cells import native_variances
from eaclutch.diagnosis.channels import CHANNELS, channels_on
from eaclutch.records import Bench, Gaussian, LoadCell

CREEP = next(c for c in CHANNELS if c.name == "hold_creep_n_s")


def ruler(values, stated):
    """(variance, degrees of freedom) of a creep that repeats as ``values`` (conditions, repeats) do."""
    count, repeats = values.shape
    names = tuple(f"c{i}" for i in range(count) for _ in range(repeats))
    conditions = SimpleNamespace(
        condition=names, session=("day",) * len(names), friction_before=np.zeros(len(names))
    )
    preload = np.full(len(names), 0.1)
    data = SimpleNamespace(
        conditions=conditions, channels=(CREEP,), run_values=values.reshape(1, -1), preload=preload
    )
    table = pd.DataFrame({CREEP.name: values.ravel(), f"{CREEP.name}_sd": stated})
    variances, dofs = native_variances(table, data)
    return variances[CREEP.name], dofs[CREEP.name]


def test_two_runs_that_happen_to_agree_are_no_ruler():
    variance, dof = ruler(np.array([[1.245e-3, 1.115e-3]]), 2.1e-3)
    assert dof == 1
    assert variance == pytest.approx(2.1e-3**2)


def test_many_repeats_are_the_ruler_whatever_the_extractor_says():
    values = np.random.default_rng(1).normal(0.0, 1e-4, (10, 3))
    variance, dof = ruler(values, 2.1e-3)
    assert dof == 20
    assert variance == pytest.approx(np.sum((values - values.mean(axis=1, keepdims=True)) ** 2) / 20)


def test_a_tolerance_is_a_share_of_what_the_bench_shows():
    slow = Bench("slow", stage_speed=1e-4, load_cell=LoadCell(mass=Gaussian(4 * 0.0011004, 5e-5)))
    units = {c.name: c.unit_scale for c in CHANNELS}
    for channel, other in zip(channels_on(Bench("published")), channels_on(slow), strict=True):
        assert channel.unit_scale == pytest.approx(units[channel.name], rel=1e-3)
        factor = {"ramp": 0.2, "release": 2.0}.get(channel.block, 1.0)
        assert other.unit_scale == pytest.approx(factor * channel.unit_scale)
