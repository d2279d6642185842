"""From evidence to probabilities: what a name gains, what it leaves and gives away, prior odds."""

from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.weigh import NONE, probabilities


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
