"""What counts, and how much: ramps that a slip may have cut, sessions that shake, and prior odds."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

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
from eaclutch.diagnosis.weigh import NONE, probabilities


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


def weighed(effects, evidence, without=0.0):
    return SimpleNamespace(
        effects=effects,
        log_evidence=evidence,
        log_evidence_open=evidence - 3.0,
        log_evidence_without=without,
        log_evidence_without_open=without - 3.0,
        log_density=(),
        gap_left_out=1.0 if effects else 2.0,
        adequate_p=0.5,
        multipliers=(1.0, 1.0),
        repeat_drift=0.0,
    )


def test_what_an_effect_gains_counts_from_the_best_base_fit():
    thresholds = load_thresholds()
    stuck = probabilities([weighed(NONE, 0.0), weighed(("gap_tilt",), 9.0)], thresholds)
    refitted = probabilities([weighed(NONE, 0.0), weighed(("gap_tilt",), 9.0, without=8.5)], thresholds)
    assert max(stuck, key=stuck.__getitem__) == ("gap_tilt",)
    assert max(refitted, key=refitted.__getitem__) == NONE
    assert sum(refitted.values()) == pytest.approx(1.0)


def test_a_nameless_remainder_counts_beside_the_best_base_fit_and_not_on_top_of_it():
    thresholds = load_thresholds()
    base = weighed(NONE, 0.0)
    base.log_evidence_without_open = 30.0
    named = weighed(("gap_tilt",), 45.0, without=25.0)
    named.log_evidence_without_open = 32.0
    found = probabilities([base, named], thresholds)
    assert max(found, key=found.__getitem__) == ("gap_tilt",)


def test_what_widens_the_gap_left_out_explains_no_part_of_it():
    thresholds = load_thresholds()
    base, named = (weighed(e, x, without=-200.0) for e, x in ((NONE, -200.0), (("gap_tilt",), -150.0)))
    base.log_evidence_without_open = 0.0
    named.log_evidence_open = 40.0
    partly = probabilities([base, named], thresholds)
    named.gap_left_out = 3.0
    wider = probabilities([base, named], thresholds)
    assert max(partly, key=partly.__getitem__) == ("gap_tilt",)
    assert max(wider, key=wider.__getitem__) == ("unknown",)


def test_a_second_effect_that_widens_the_gap_left_out_explains_no_part_of_it():
    thresholds = load_thresholds()
    base, named = weighed(NONE, -400.0, without=-400.0), weighed(("gap_tilt",), -300.0, without=-400.0)
    pair = weighed(("gap_tilt", "slow_drive"), -290.0, without=-400.0)
    base.log_evidence_without_open, named.log_evidence_open, pair.log_evidence_open = -80.0, -20.0, 0.0
    narrower = probabilities([base, named, pair], thresholds)
    pair.gap_left_out = 1.02  # by chance
    as_good = probabilities([base, named, pair], thresholds)
    pair.gap_left_out = 1.5  # less than the base model's 2, more than the 1 of one effect alone
    wider = probabilities([base, named, pair], thresholds)
    assert max(narrower, key=narrower.__getitem__) == max(as_good, key=as_good.__getitem__) == pair.effects
    assert max(wider, key=wider.__getitem__) == named.effects


def test_what_widens_the_gap_left_out_may_still_swing():
    """The gap holds no swings, and fits around a large one end a few percent apart."""
    thresholds = load_thresholds()
    two = ("series_compliance", "trigger_latency")
    leads = {}
    for third in ("load_cell_dynamics", "air_gap"):
        base, pair = weighed(NONE, -400.0, without=-400.0), weighed(two, -90.0, without=-400.0)
        three = weighed((third, *two), -120.0, without=-400.0)
        pair.log_evidence_open, three.log_evidence_open = -60.0, -20.0
        pair.gap_left_out, three.gap_left_out = 1.0, 1.1
        found = probabilities([base, pair, three], thresholds)
        leads[third] = max(found, key=found.__getitem__)
    assert leads == {"load_cell_dynamics": ("load_cell_dynamics", *two), "air_gap": two}


def test_around_a_gap_that_none_closes_it_counts_how_far_one_narrows_it():
    thresholds = load_thresholds()
    base = weighed(NONE, -900.0, without=-900.0)
    single, pair = weighed(("gap_tilt",), 0.0, -900.0), weighed(("gap_tilt", "slow_drive"), 2.0, -900.0)
    single.gap_left_out, pair.gap_left_out = 1.8, 1.0
    usual = probabilities([base, single, pair], thresholds)
    assert max(usual, key=usual.__getitem__) == single.effects
    for result in (single, pair):
        result.multipliers = (16.0, 1.0)
    wide = probabilities([base, single, pair], thresholds)
    assert max(wide, key=wide.__getitem__) == pair.effects
    odds = [np.log(p[pair.effects] / p[single.effects]) * thresholds["temperature"] for p in (usual, wide)]
    assert odds[1] - odds[0] == pytest.approx(thresholds["narrowing_weight"] * np.log(1.8))


def corrected(unknown):
    """Probability of ``unknown`` once its odds against names are corrected, where nothing else is probable."""
    odds = load_thresholds()["unknown_odds"] * unknown / (1.0 - unknown)
    return odds / (1.0 + odds)


def test_the_best_name_is_no_sure_name_where_its_fit_fails_the_absolute_check():
    thresholds = load_thresholds()
    base, named = weighed(NONE, -200.0, without=-200.0), weighed(("gap_tilt",), 0.0, without=-200.0)
    fits = probabilities([base, named], thresholds)
    named.adequate_p = 0.005
    misfits = probabilities([base, named], thresholds)
    assert fits[("gap_tilt",)] == pytest.approx(1.0) and fits[("unknown",)] == pytest.approx(0.0, abs=1e-9)
    assert misfits[("unknown",)] == pytest.approx(corrected(thresholds["misfit_share"]))
    assert sum(misfits.values()) == pytest.approx(1.0)


def test_nor_where_a_nameless_remainder_gains_much_beside_it():
    thresholds = load_thresholds()
    base, named = weighed(NONE, -200.0, without=-200.0), weighed(("gap_tilt",), 0.0, without=-200.0)
    found = []
    for gain in (0.99, 1.01):
        named.log_evidence_open = gain * thresholds["misfit_remainder"]
        found.append(probabilities([base, named], thresholds)[("unknown",)])
    assert found == pytest.approx([0.0, corrected(thresholds["misfit_share"])], abs=1e-9)


def test_a_name_that_surely_widens_the_gap_left_out_is_no_sure_name():
    thresholds = load_thresholds()
    base, named = weighed(NONE, -200.0, without=-200.0), weighed(("gap_tilt",), 0.0, without=-200.0)
    just_not = probabilities([base, named], thresholds, {("gap_tilt",): thresholds["widening"]["times"]})
    assert just_not[("gap_tilt",)] == pytest.approx(1.0)
    surely = {("gap_tilt",): 1.01 * thresholds["widening"]["times"]}
    found = probabilities([base, named], thresholds, surely)
    assert found[("unknown",)] == pytest.approx(corrected(thresholds["widening"]["share"]))
    assert sum(found.values()) == pytest.approx(1.0)
    of_large = {("gap_tilt",): 1.01 * thresholds["widening"]["of_large"]}
    kept = []
    for gap in (0.99, 1.01):
        base.gap_left_out = gap * thresholds["large_gap"]
        kept.append(probabilities([base, named], thresholds, of_large)[("gap_tilt",)])
    assert kept == pytest.approx([1.0, found[("gap_tilt",)]])
    base.gap_left_out = 1.0
    named.adequate_p = 0.005
    also_misfits = probabilities([base, named], thresholds, surely)
    left = (1 - thresholds["widening"]["share"]) * (1 - thresholds["misfit_share"])
    assert also_misfits[("gap_tilt",)] == pytest.approx(1.0 - corrected(1.0 - left))


def test_a_name_that_fails_the_check_and_surely_leaves_much_of_the_gap_gives_more_away():
    thresholds = load_thresholds()
    partly = thresholds["partly"]
    assert partly["share"] > thresholds["misfit_share"]
    base, named = weighed(NONE, -200.0, without=-200.0), weighed(("gap_tilt",), 0.0, without=-200.0)
    base.gap_left_out = 1.01 * thresholds["large_gap"]
    much, little = ({("gap_tilt",): factor * partly["times"]} for factor in (1.01, 0.99))
    assert probabilities([base, named], thresholds, much)[("gap_tilt",)] == pytest.approx(1.0)
    named.adequate_p = 0.005
    unknown = [probabilities([base, named], thresholds, left)[("unknown",)] for left in (much, little)]
    assert unknown[0] == pytest.approx(corrected(partly["share"]))
    assert unknown[1] == pytest.approx(corrected(thresholds["misfit_share"]))
    base.gap_left_out = 0.99 * thresholds["large_gap"]  # where little can be closed most of it is left
    small = probabilities([base, named], thresholds, much)
    assert small[("unknown",)] == pytest.approx(corrected(thresholds["misfit_share"]))


def test_odds_against_what_nobody_wrote_down_count_in_part_and_order_nothing_anew():
    thresholds = load_thresholds()
    base, named = weighed(NONE, -200.0, without=-200.0), weighed(("gap_tilt",), 0.0, without=-200.0)
    base.log_evidence_without_open = -25.0
    believed = probabilities([base, named], dict(thresholds) | {"against_unknown": 1.0})
    found = probabilities([base, named], thresholds)
    more = np.log(thresholds["unknown_odds"])
    odds = [np.log(p[("unknown",)] / p[("gap_tilt",)]) - more for p in (believed, found)]
    assert odds[1] == pytest.approx(thresholds["against_unknown"] * odds[0]) and odds[1] < 0
    base.log_evidence_without_open = 25.0  # the other way round nothing changes
    believed = probabilities([base, named], dict(thresholds) | {"against_unknown": 1.0})
    assert probabilities([base, named], thresholds) == pytest.approx(believed)
    assert max(believed, key=believed.__getitem__) == ("unknown",)


def test_the_odds_of_unknown_are_corrected_against_names_alone():
    thresholds = load_thresholds()
    results = [weighed(NONE, 0.0), weighed(("gap_tilt",), 6.0)]
    plain = probabilities(results, dict(thresholds) | {"unknown_odds": 1.0})
    found = probabilities(results, dict(thresholds) | {"unknown_odds": 3.0})
    assert found[NONE] == pytest.approx(plain[NONE])
    ratio = [p[("unknown",)] / p[("gap_tilt",)] for p in (plain, found)]
    assert ratio[1] == pytest.approx(3.0 * ratio[0])
    assert sum(found.values()) == pytest.approx(1.0)


def test_an_effect_is_as_likely_beforehand_beside_few_others_as_beside_many():
    thresholds = load_thresholds()
    few = probabilities([weighed(NONE, 0.0), weighed(("gap_tilt",), 4.0)], thresholds)
    names = ["gap_tilt", *(f"effect_{i}" for i in range(15))]
    many = [weighed((name,), 4.0 if name == "gap_tilt" else -50.0) for name in names]
    all_of_them = probabilities([weighed(NONE, 0.0), *many], thresholds)
    assert few[("gap_tilt",)] == pytest.approx(all_of_them[("gap_tilt",)], rel=1e-6)


def test_a_session_drift_must_gain_more_than_sessions_always_differ_by():
    """8 nats make any other effect a name and no drift; the same holds for a drift beside another effect."""
    thresholds = load_thresholds()

    def said(*found):
        weights = probabilities([weighed(NONE, 0.0), *found], thresholds)
        return max(weights, key=weights.__getitem__)

    assert said(weighed(("gap_tilt",), 8.0)) == ("gap_tilt",)
    assert said(weighed(("session_drift",), 8.0)) == NONE
    assert said(weighed(("session_drift",), 20.0)) == ("session_drift",)
    late, both = ("trigger_latency",), ("session_drift", "trigger_latency")
    assert said(weighed(late, 30.0), weighed(both, 38.0)) == late
    assert said(weighed(late, 30.0), weighed(both, 48.0)) == both


def test_repeats_that_drift_are_no_repeatability_and_no_name_either():
    thresholds = load_thresholds()
    base, named = weighed(NONE, 0.0), weighed(("gap_tilt",), 3.0)
    still = probabilities([base, named], thresholds)
    assert max(still, key=still.__getitem__) == NONE
    base.repeat_drift = 14.0
    drifting = probabilities([base, named], thresholds)
    assert drifting[("unknown",)] > 0.9 * still[NONE]
    assert drifting[NONE] < 0.01
    assert drifting[("gap_tilt",)] <= still[("gap_tilt",)]
    assert sum(drifting.values()) == pytest.approx(1.0)
    base.repeat_drift = (
        1.0  # a nat: the odds of unknown against no effect grow by no more than that, whatever the prior
    )
    hardly = probabilities([base, named], thresholds)
    assert max(hardly, key=hardly.__getitem__) == NONE
    odds = [found[("unknown",)] / found[NONE] for found in (still, hardly)]
    assert 1.0 < odds[1] / odds[0] < np.e
