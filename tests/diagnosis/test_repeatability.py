"""The ruler: variance of repeats, whatever differs between conditions or follows the preload."""

import numpy as np
import pytest

from eaclutch.diagnosis.repeatability import RepeatVariance, pooled_variance, preload_bins, shrunk_variance


def test_condition_means_and_preload_do_not_count_as_scatter():
    rng = np.random.default_rng(1)
    groups = np.repeat(np.arange(200), 4)
    before = rng.uniform(0.0, 0.1, groups.size)
    values = 10.0 * groups + 3.0 * before + rng.normal(0.0, 0.2, groups.size)
    found = pooled_variance(values, before, groups, np.zeros(groups.size, dtype=int))
    assert found.dof == 200 * 3 - 1
    assert found.variance == pytest.approx(0.04, rel=0.15)


def test_a_missing_value_costs_one_degree_of_freedom():
    values = np.array([1.0, 2.0, np.nan, 5.0, 7.0])
    groups = np.array([0, 0, 0, 1, 1])
    found = pooled_variance(values, np.zeros(5), groups, np.zeros(5, dtype=int))
    assert found.dof == 2
    assert found.variance == pytest.approx((0.5 + 2.0) / 2)


def test_a_run_that_is_hardly_known_does_not_stretch_the_ruler_for_all():
    """Sixty runs that scatter by 5 %, and one of a dying load cell, a third of the others and known to a half."""
    rng = np.random.default_rng(1)
    groups, zero = np.repeat(np.arange(20), 3), np.zeros(60, dtype=int)
    sd = np.full(60, 0.02)
    values = rng.normal(0.0, np.hypot(0.05, sd))
    values[30], sd[30] = -1.5, 0.5
    assert pooled_variance(values, zero, groups, zero).variance > 0.15**2
    found = pooled_variance(values, zero, groups, zero, sd**2)
    assert found.dof == 40
    assert np.sqrt(found.variance) == pytest.approx(np.hypot(0.05, 0.02), rel=0.25)


def test_what_each_run_is_known_by_is_no_scatter_of_the_others():
    """Half of the runs are known to 20 %, half to 1 %: the scatter beyond that is found, whatever the mixture."""
    rng = np.random.default_rng(2)
    groups, before = np.repeat(np.arange(300), 4), rng.uniform(0.0, 0.1, 1200)
    sd = np.tile([0.2, 0.01, 0.2, 0.01], 300)
    for scatter in (0.05, 0.0):
        values = 10.0 * groups + 3.0 * before + rng.normal(0.0, np.hypot(scatter, sd))
        found = pooled_variance(values, before, groups, np.zeros(1200, dtype=int), sd**2)
        beyond = np.sqrt(found.variance - np.median(sd**2))
        assert beyond == pytest.approx(scatter, rel=0.1, abs=0.006)


@pytest.mark.parametrize("seed", range(4))
def test_without_an_own_uncertainty_repeats_scatter_as_they_do(seed):
    rng = np.random.default_rng(seed)
    groups, zero = np.repeat(np.arange(10), 3), np.zeros(30, dtype=int)
    values = rng.normal(0.0, 0.1, 30)
    plain, told = (pooled_variance(values, zero, groups, zero, own) for own in (None, np.zeros(30)))
    assert told.variance == pytest.approx(plain.variance) and told.beyond == told.variance
    unknown = np.where(np.arange(30) == 4, np.inf, 0.0)
    without = np.where(np.arange(30) == 4, np.nan, values)
    assert pooled_variance(values, zero, groups, zero, unknown).variance == pytest.approx(
        pooled_variance(without, zero, groups, zero).variance
    )


def test_no_repeats_fall_back_on_the_prior():
    lonely = pooled_variance(np.arange(3.0), np.zeros(3), np.arange(3), np.zeros(3, dtype=int))
    assert lonely.dof == 0
    assert shrunk_variance(lonely, 0.7, 3.0) == 0.7
    assert shrunk_variance(RepeatVariance(1.0, 9), 0.0, 3.0) == pytest.approx(0.75)


def test_preload_bins_are_those_that_conditions_are_named_by():
    names = [
        "brass_w2_t2_300V_10Hz_p0-0.2N",
        "brass_w2_t2_300V_DC_p0.2-infN",
        "brass_w2_t2_250V_10Hz_p0-0.2N",
    ]
    assert preload_bins(names, np.array([0.1, 0.22, 0.15])).tolist() == [0, 1, 0]
    assert preload_bins(["a", "a_plate_300V", "c"], np.array([0.1, 0.22, 0.3])).tolist() == [0, 0, 1]
