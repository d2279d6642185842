"""Which runs count, and how much: ramps that a slip may have cut, odd values, sessions that shake."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.channels import CHANNELS
from eaclutch.diagnosis.conclude import caveats
from eaclutch.diagnosis.repeatability import pooled_variance, session_share
from eaclutch.diagnosis.screening import (
    lone,
    misplaced,
    reaches,
    reckoned,
    scaled_column,
    slips_at_switch_off,
    wrongly_reckoned,
)
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study


def test_a_run_that_slips_as_the_voltage_falls_did_not_start_from_rest():
    ten, half = [1.2e-4, 0.0, 1.2e-4, np.nan], [3e-4, 3e-4, 1e-4, 3e-4]
    table = pd.DataFrame({"release_time_10_s": ten, "release_time_50_s": half})
    assert slips_at_switch_off(table, 3.9e-4).tolist() == [False, True, True, False]
    assert not slips_at_switch_off(pd.DataFrame({"run": ["a"]}), 3.9e-4).any()


def test_a_ramp_counts_only_where_no_slip_can_come_so_early():
    channel = next(c for c in CHANNELS if c.name == "ramp_rate_n_s")  # up to 20 ms: 0.18 N at 9 N/s
    table = pd.DataFrame({"shear_capacity_n": [0.1, 0.24, 0.6], "friction_before_n": [0.05, 0.2, 0.05]})
    np.testing.assert_array_equal(reaches(table, channel, 9.0), [False, False, True])


def test_a_zero_that_the_fit_knows_is_no_uncertainty_of_a_run():
    channel = next(c for c in CHANNELS if c.name == "slip_fraction")
    table = pd.DataFrame({"slip_fraction": [0.1, 0.2], "slip_fraction_sd": [0.03, 0.01]})
    np.testing.assert_allclose(scaled_column(table, channel)[1], [0.03, 0.01])
    table["slip_fraction_sd_zero_known"] = [0.02, np.nan]
    np.testing.assert_allclose(scaled_column(table, channel)[1], [0.02, 0.01])


def test_a_slip_while_the_stage_rests_is_no_creep():
    table = pd.DataFrame(
        {"hold_creep_n_s": [-0.3, -0.01, -0.3], "flags": ["no_zero;slips_at_rest", np.nan, "no_zero"]}
    )
    table["shear_capacity_n"] = 0.5
    shown = {c.name: scaled_column(table, c)[0] for c in CHANNELS if c.name in table}
    np.testing.assert_array_equal(np.isnan(shown["hold_creep_n_s"]), [True, False, False])
    assert np.isfinite(shown["shear_capacity_n"]).all()


def test_a_run_whose_times_were_reckoned_wrong_stands_apart_from_its_condition():
    """Lines lost in small pieces: a release 1.6 ms late in a session that has no repeat of it; an effect that delays
    one session's runs, and a reckoned run among its like, stay."""
    rng = np.random.default_rng(5)
    conditions, residual = np.repeat(np.arange(8), 3), rng.normal(0.0, 0.05, 24)
    flags = np.full(24, "", dtype=object)
    flags[[4, 7, 10]] = "force_lines_lost;force_realigned_from_release", "no_zero;voltage_lines_lost", np.nan
    moved = reckoned(pd.DataFrame({"flags": flags}))
    assert np.flatnonzero(moved).tolist() == [4, 7]
    residual[4] += 3.2
    residual[20] += 3.2
    assert np.flatnonzero(misplaced(residual, np.full(24, 0.05), conditions, moved)).tolist() == [4]
    alone = conditions.copy()
    alone[7] = 99  # no other run of its condition confirms it
    assert np.flatnonzero(misplaced(residual, np.full(24, 0.05), alone, moved)).tolist() == [4, 7]
    assert not reckoned(pd.DataFrame({"run": ["a"]})).any()


def test_a_value_that_no_other_run_of_its_condition_comes_near_is_odd():
    """Of lone runs (one a condition and session) and of two repeats; what a whole session or more than one run of a
    condition does is no odd value, nor what a first fit explains."""
    rng = np.random.default_rng(7)
    conditions, sessions = np.repeat(np.arange(12), 4), np.tile(["a", "a", "b", "c"], 12)
    values, sd = rng.normal(0.0, 0.05, 48) + 0.3 * (sessions == "b"), np.full(48, 0.01)

    def odd(*changed, explained=0.0):
        moved = values.copy()
        for run, by in changed:
            moved[run] += by
        return np.flatnonzero(lone([moved, moved - explained], sd, conditions, sessions)).tolist()

    assert odd() == []
    assert odd((10, 0.7), (21, -2.0)) == [10, 21]  # alone in its session; one of two repeats
    assert odd((10, 0.2)) == []
    assert odd((10, 0.7), explained=np.where(np.arange(48) == 10, 0.7, 0.0)) == []
    assert odd((8, 0.7), (9, 0.7)) == []  # repeats that bear each other out
    assert odd((10, 0.7), (11, -0.7)) == []  # of these which is odd
    assert odd((10, 0.7), (14, 0.7)) == []  # session b differs there
    assert lone([values[:8]], sd[:8], conditions[:8], sessions[:8]).sum() == 0


def test_an_odd_value_is_left_out_of_its_observable_and_told():
    """Three sessions with one run a condition; the shear capacity of one run is read twenty times too large."""
    asked = inputs(days=3, repeats=3)
    table = asked.table.copy()
    table.loc[7, "shear_capacity_n"] *= 20.0
    study = Study(replace(asked, table=table), load_thresholds())
    told = f"shear_capacity_n of {table.run[7]}"
    assert study.data.odd == (told,)
    assert any(told in note and "left out" in note for note in caveats(study))
    names = [channel.name for channel in study.data.channels]
    missing = np.isnan(study.data.run_values[:, 7])
    assert missing[names.index("shear_capacity_n")]
    assert not missing[names.index("release_time_50_s")]


def test_a_first_fit_is_made_without_runs_whose_times_were_reckoned():
    """It says what differs from run to run; after it those that another run confirms come back."""
    channel = next(c for c in CHANNELS if c.name == "release_time_50_s")
    times = 4e-4 + 1e-5 * np.random.default_rng(3).normal(size=12)
    times[4] += 2e-3
    flags = np.full(12, "", dtype=object)
    flags[[4, 7]] = "force_realigned_from_release"
    table = pd.DataFrame({channel.name: times, f"{channel.name}_sd": 1e-5, "flags": flags})
    conditions = [f"c{i // 3}" for i in range(12)]
    assert np.flatnonzero(wrongly_reckoned(table, conditions, (channel,), None)).tolist() == [4, 7]
    explained = np.zeros((1, 12))
    assert np.flatnonzero(wrongly_reckoned(table, conditions, (channel,), explained)).tolist() == [4]


@dataclass(frozen=True)
class Runs:
    """As much of the runs' conditions as the variance of a session looks at."""

    session: tuple[str, ...]
    friction_before: np.ndarray

    def __len__(self):
        return len(self.session)


def test_a_shaking_session_counts_less_and_a_lucky_one_no_more():
    rng = np.random.default_rng(2)
    groups = np.repeat(np.arange(60), 3)
    session = np.where(groups < 20, "calm", np.where(groups < 40, "shaky", "usual"))
    sd = np.select([session == "calm", session == "shaky"], [0.05, 0.5], 0.1)
    values, zero = rng.normal(0.0, sd), np.zeros(groups.size)
    bins = np.zeros(groups.size, dtype=int)
    conditions = Runs(tuple(session), zero)
    pooled = pooled_variance(values, zero, groups, bins)
    share = session_share(values, pooled, conditions, groups, bins)
    assert np.all(share[session == "calm"] == 1.0)
    assert share[session == "shaky"].mean() * pooled.variance == pytest.approx(0.25, rel=0.4)
