"""Which two effects are weighed together: a second one is looked for where the first one has already been fitted."""

from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest

from diagnosis.simulated import CONDITIONS, inputs
from eaclutch.diagnosis.counted import counted_evidence
from eaclutch.diagnosis.pairs import _leaders, weigh_pairs
from eaclutch.diagnosis.refits import CLOSE, Fit, afresh, weigh_fit, worth_again
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.spread import Spread
from eaclutch.diagnosis.starts import scout, scout_shifts
from eaclutch.diagnosis.study import Study
from eaclutch.physics.effects import BASE

KNOWN = tuple(effect for effect in BASE if effect != "load_cell_dynamics")
CANDIDATES = ("load_cell_dynamics", "series_compliance", "trigger_latency", "slow_drive")


def test_a_second_effect_is_found_that_shows_only_beside_the_first():
    """A model without the load cell's swing, a bench with that and a soft train: a delay alone comes near the
    best single, and beside the delay the soft train promises more than the swing."""
    given = inputs(("series_compliance",), {"series_compliance.compliance": 6e-5})
    study = Study(replace(given, effects=KNOWN, candidates=CANDIDATES), load_thresholds(), seed=3)
    singles = [study.weigh(())] + [study.weigh((name,)) for name in study.candidates]
    alone = next(r for r in singles if r.effects == ("trigger_latency",))
    assert alone.log_evidence > max(r.log_evidence for r in singles) - 30.0
    # fitted around so large a gap, and checked at usual tolerances all the same
    assert alone.multipliers[0] > 2.0
    assert alone.adequate_p < 0.01
    best, *others = weigh_pairs(Spread(study), singles, 1)
    assert best.effects == ("load_cell_dynamics", "series_compliance")
    assert best.log_evidence > max(r.log_evidence for r in singles) + 50.0
    # around so large a gap the foremost singles' pairs are fitted beyond the limit, too
    foremost = sorted(singles, key=counted_evidence(singles, study.thresholds), reverse=True)[:3]
    names = sorted(single.effects[0] for single in foremost)
    assert {best.effects} | {pair.effects for pair in others} >= set(combinations(names, 2))


def test_a_base_fit_that_did_better_elsewhere_does_not_end_the_search_for_more():
    """What a single gains over the base model as it was found says that there is a gap to look into."""
    base = SimpleNamespace(effects=(), log_evidence=0.0, log_evidence_without=0.0, gap_left_out=2.0)
    single = SimpleNamespace(
        effects=("gap_tilt",),
        log_evidence=9.0,
        log_evidence_open=6.0,
        log_evidence_without=8.0,
        gap_left_out=1.0,
        multipliers=(1.0, 1.0),
    )
    results = [base, single]
    assert _leaders(results, counted_evidence(results, load_thresholds())) == [1]


def test_what_needed_wide_tolerances_is_fitted_afresh_and_nothing_else_is():
    study = SimpleNamespace(thresholds=load_thresholds())
    usual = SimpleNamespace(effects=("gas_slip",), multipliers=(2.0, 1.0))
    wide = SimpleNamespace(effects=("gap_tilt",), multipliers=(4.0, 1.0))
    (fit,) = afresh(study, [usual, wide])
    assert fit.effects == ("gap_tilt",)
    assert fit.afresh == (4.0, 1.0)  # as wide as it was found to need


def test_what_stands_far_behind_is_made_again_only_around_a_large_gap():
    study = SimpleNamespace(thresholds=load_thresholds())
    stands = {
        "gas_slip": (0.0, 4.0),
        "gap_tilt": (100.0 - CLOSE - 1.0, 2.0),
        "edge_wrap": (100.0 - CLOSE + 1.0, 2.0),
    }
    results = [
        SimpleNamespace(effects=(name,), log_evidence=nats, multipliers=(tolerance, 1.0))
        for name, (nats, tolerance) in stands.items()
    ]
    lead = SimpleNamespace(effects=("slow_drive",), log_evidence=100.0, multipliers=(1.0, 1.0))
    found = worth_again(study, results, [*results, lead], lambda result: result.log_evidence)
    assert [r.effects for r in found] == [("gas_slip",), ("edge_wrap",)]


def test_fits_are_the_same_in_one_process_and_in_two_and_come_in_order():
    study = Study(inputs(conditions=CONDITIONS[:4], repeats=2), load_thresholds(), seed=3)
    study.weigh(())
    fits = [
        Fit(("trigger_latency",)),
        Fit(("series_compliance",), afresh=(1.0, 1.0)),
        Fit(("stray_capacitance",)),
    ]
    with Spread(study) as one, Spread(study, 2) as two:
        alone, together = one(weigh_fit, fits), two(weigh_fit, fits)
    assert [made.effects for made in together] == [fit.effects for fit in fits]
    assert [made.document() for made in alone] == [made.document() for made in together]


def test_a_fit_made_afresh_needs_no_base_fit():
    study = Study(
        inputs(("series_compliance",), {"series_compliance.compliance": 2.5e-5}), load_thresholds(), seed=3
    )
    afresh = study.fit(("series_compliance",), afresh=(1.0, 1.0))
    assert "base" not in study.__dict__
    usual = study.fit(("series_compliance",))
    assert afresh.log_evidence == pytest.approx(usual.log_evidence, abs=1.0)


def test_only_the_second_effect_is_scouted_on_top_of_the_first():
    study = Study(inputs(), load_thresholds())
    first = study.fit(("series_compliance",))
    forward = study.forward(("series_compliance", "trigger_latency"))
    shift, cost = scout_shifts(forward, first)
    alone, cost_alone = scout_shifts(study.forward(("trigger_latency",)), study.base)
    np.testing.assert_allclose(cost, cost_alone)
    # a delay moves release times alike, however soft the train is
    times = np.char.startswith(study.data.channel.astype(str), "release_time")
    np.testing.assert_allclose(shift[:, times], alone[:, times], atol=0.5)


@pytest.mark.parametrize("name", ["session_drift", "reading_drift"])
def test_an_effect_that_may_go_both_ways_is_also_fitted_from_where_it_does_nothing(name):
    """Sessions that are all off, and must come back, end where they do a great deal worse than the base model."""
    study = Study(inputs(conditions=CONDITIONS[:4], repeats=2), load_thresholds())
    forward = study.forward((name,))
    first = scout(forward, study.base, study.kernels.total())[0]
    found = forward.predict(forward.priors.from_normal(first))[0]
    np.testing.assert_allclose(found, study.forward(()).predict(study.base.mode.theta)[0], atol=1e-6)
