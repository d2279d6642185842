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
