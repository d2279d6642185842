"""The ruler that a gap is measured with."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from eaclutch.diagnosis.cells import native_variances
from eaclutch.diagnosis.channels import CHANNELS, channels_on
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.records import Bench, Gaussian, LoadCell

CREEP, REST, CAPACITY = (
    next(c for c in CHANNELS if c.name == name)
    for name in ("hold_creep_n_s", "baseline_shift_n", "shear_capacity_n")
)
USUAL = load_thresholds()["unrepeated_sd"]


def ruler(values, stated, channel=CREEP):
    """(variance, degrees of freedom) of an observable that repeats as ``values`` (conditions, repeats) do."""
    count, repeats = values.shape
    names = tuple(f"c{i}" for i in range(count) for _ in range(repeats))
    conditions = SimpleNamespace(
        condition=names, session=("day",) * len(names), friction_before=np.zeros(len(names))
    )
    preload = np.full(len(names), 0.1)
    data = SimpleNamespace(
        conditions=conditions, channels=(channel,), run_values=values.reshape(1, -1), preload=preload
    )
    table = pd.DataFrame({channel.name: values.ravel(), f"{channel.name}_sd": stated})
    variances, dofs = native_variances(table, data, load_thresholds())
    return variances[channel.name], dofs[channel.name]


def test_two_runs_that_happen_to_agree_are_no_ruler():
    variance, dof = ruler(np.array([[1.245e-3, 1.115e-3]]), 2.1e-3)
    usual = 2.1e-3**2 + (USUAL["creep"] * CREEP.unit_scale) ** 2
    assert dof == 1
    assert variance == pytest.approx((0.5 * 1.3e-4**2 + 3 * usual) / 4)


def test_without_repeats_a_run_scatters_as_runs_usually_do():
    """A place of rest is read to half a millinewton and reached by chance; a capacity scatters by a share of itself."""
    rest, dof = ruler(np.array([[0.01], [0.03]]), 5e-4, REST)
    assert dof == 0
    assert rest == pytest.approx(5e-4**2 + (USUAL["after"] * REST.unit_scale) ** 2)
    capacity, _ = ruler(np.array([[3.0], [4.0]]), 4e-3, CAPACITY)
    assert capacity == pytest.approx(4e-3**2 + USUAL["capacity"] ** 2 * 12.5)


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
