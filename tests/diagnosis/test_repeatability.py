"""The ruler: variance of repeats, whatever differs between conditions or follows the preload."""

from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.diagnosis.repeatability import (
    RepeatVariance,
    across_sessions,
    instead,
    pooled_variance,
    preload_bins,
    run_variance,
    shrunk_variance,
)


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


def once_a_session(conditions=20, sessions=3, sd=0.1, seed=2):
    """(values, runs) of a campaign that visits every condition once a session; conditions and sessions differ."""
    rng = np.random.default_rng(seed)
    condition, session = np.tile(np.arange(conditions), sessions), np.repeat(np.arange(sessions), conditions)
    values = rng.normal(0.0, 5.0, conditions)[condition] + rng.normal(0.0, 2.0, sessions)[session]
    runs = SimpleNamespace(
        condition=[f"c{i}" for i in condition],
        session=[f"day {i}" for i in session],
        friction_before=0.0 * values,
    )
    return values + rng.normal(0.0, sd, len(values)), runs


def test_runs_that_repeat_in_other_sessions_only_show_their_scatter_there():
    found = [across_sessions(*once_a_session(seed=seed)) for seed in range(40)]
    assert np.mean([f.variance for f in found]) == pytest.approx(0.01, rel=0.15)
    spread = np.var([f.variance for f in found]) / 0.01**2
    assert found[0].dof == 14  # of 38: scatter by a median is as sure as that of so many repeats
    assert spread == pytest.approx(2.0 / found[0].dof, rel=0.5)


def test_a_few_odd_runs_are_no_scatter_across_sessions():
    values, runs = once_a_session()
    plain = across_sessions(values, runs).variance
    values[[3, 30]] += 5.0
    assert across_sessions(values, runs).variance < 2.5 * plain


def test_what_few_conditions_or_one_session_show_is_no_scatter():
    for conditions, sessions in ((20, 1), (4, 2)):
        found = across_sessions(*once_a_session(conditions, sessions))
        assert found.dof == 0 and np.isnan(found.variance)
    values, runs = once_a_session()
    values[20:] = np.nan
    assert across_sessions(values, runs).dof == 0
    assert across_sessions(np.full(60, np.nan), runs).dof == 0


def test_scatter_across_sessions_counts_where_repeats_are_few_and_not_where_they_are_many():
    values, runs = once_a_session()
    quiet, _ = once_a_session(sd=0.05)
    least = across_sessions(quiet, runs)
    assert instead(RepeatVariance(1.0, 4), [values, quiet], runs) == least
    assert instead(RepeatVariance(1.0, 5), [values, quiet], runs).dof == 0
    thresholds, all_used = {"repeat_sd": {"capacity": 0.03}, "repeat_prior_dof": 3.0}, np.ones(4, dtype=bool)

    def sd(repeat, across):
        return np.sqrt(run_variance(repeat, across, np.zeros(4), all_used, thresholds, "capacity"))

    seen, none = RepeatVariance(0.1**2, 14), RepeatVariance(np.nan, 0)
    np.testing.assert_allclose(sd(none, none), 0.03)
    np.testing.assert_allclose(sd(none, seen), np.sqrt((14 * 0.1**2 + 3 * 0.03**2) / 17))
    few = RepeatVariance(0.05**2, 2)
    np.testing.assert_allclose(sd(few, seen), np.sqrt((2 * 0.05**2 + 14 * 0.1**2 + 3 * 0.03**2) / 19))
