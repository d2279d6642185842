"""What only looks like an effect of the library competes with it, and is never named."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from diagnosis.simulated import CONDITIONS, inputs
from eaclutch.diagnosis.conclude import conclude
from eaclutch.diagnosis.pairs import NEAR, WORTH_A_LOOK, _weigh_lookalikes, with_pairs
from eaclutch.diagnosis.promises import promises
from eaclutch.diagnosis.refits import CLOSE
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.spread import Spread
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import UNKNOWN, left_as, probabilities, unknown_as
from eaclutch.physics.effects import BASE, LOOKALIKES
from eaclutch.records import InputError

THRESHOLDS = load_thresholds()
HEAVIER = [
    {"voltage_v": v, "frequency_hz": f, "width_mm": 2, "preload_n": 0.5}
    for v, f in [(300, 10), (300, 10000), (250, 1000)]
]


def weighed(effects, evidence, remainder=-1e3):
    return SimpleNamespace(
        effects=effects, log_evidence=evidence, log_evidence_open=remainder, log_evidence_without=0.0,
        log_evidence_without_open=10.0, log_density=(), gap_left_out=1.0, adequate_p=1.0, multipliers=(1.0, 1.0),
        repeat_drift=0.0,
    )  # fmt: skip


def test_what_a_lookalike_wins_is_unknowns():
    results = [weighed((), 0.0), weighed(("substrate_inertia",), 40.0)]
    alone = probabilities(results, THRESHOLDS)
    behind = probabilities([*results, weighed(("readout_lag",), 20.0)], THRESHOLDS)
    level = probabilities([*results, weighed(("readout_lag",), 40.0)], THRESHOLDS)
    ahead = probabilities([*results, weighed(("readout_lag",), 60.0)], THRESHOLDS)
    assert behind[UNKNOWN] == pytest.approx(alone[UNKNOWN], abs=1e-6)
    # less probable beforehand than an effect of the library
    assert level[UNKNOWN] == pytest.approx(
        THRESHOLDS["unknown_odds"] * THRESHOLDS["prior"]["lookalike_share"] * level["substrate_inertia",]
        + alone[UNKNOWN] * level["substrate_inertia",] / alone["substrate_inertia",]
    )
    likelier = probabilities([*results, weighed(("leaky_film",), 40.0)], THRESHOLDS)
    share = {found: weights[UNKNOWN] / weights["substrate_inertia",] for found, weights in
             (("alone", alone), ("level", level), ("likelier", likelier))}  # fmt: skip
    assert share["likelier"] - share["alone"] == pytest.approx(
        THRESHOLDS["prior"]["odds"]["leaky_film"] * (share["level"] - share["alone"])
    )
    assert ahead[UNKNOWN] > 0.99
    for found in (behind, level, ahead):
        assert set(found) == {(), ("substrate_inertia",), UNKNOWN}
        assert sum(found.values()) == pytest.approx(1.0)


def test_a_name_keeps_what_a_lookalike_explains_beside_it():
    both = ("edge_wrap", "series_compliance")
    results = [weighed((), 0.0), weighed(("series_compliance",), 40.0), weighed(("edge_wrap",), 10.0)]
    results.append(weighed(both, 60.0))
    pair = probabilities(results, THRESHOLDS)
    drag = weighed(("series_compliance", "viscous_drag"), 60.0)
    level = probabilities([*results, drag], THRESHOLDS)
    ahead = probabilities([*results, replace_evidence(drag, 90.0)], THRESHOLDS)
    assert left_as([*results, drag], THRESHOLDS, ("series_compliance",)) == "viscous_drag"
    assert left_as(results, THRESHOLDS, ("series_compliance",)) == ""
    assert left_as([*results, replace_evidence(drag, 40.0)], THRESHOLDS, ("series_compliance",)) == ""
    assert pair[both] > 0.9
    # as probable as another pair, but for what a lookalike is less so beforehand
    alone = pair["series_compliance",] / pair[both]
    assert level["series_compliance",] / level[both] - alone == pytest.approx(
        THRESHOLDS["prior"]["lookalike_share"], rel=1e-6
    )
    assert ahead["series_compliance",] > 0.9
    assert set(ahead) == set(pair)
    assert sum(ahead.values()) == pytest.approx(1.0)


def replace_evidence(result, evidence):
    return SimpleNamespace(**vars(result) | {"log_evidence": evidence})


def test_a_drag_beside_a_soft_train_is_no_edge_wrap():
    given = inputs(
        ("series_compliance", "viscous_drag"),
        {
            "series_compliance.compliance": 2.5e-5,
            "series_compliance.film_share": 0.9,
            "viscous_drag.drag": 1.5,
        },
        conditions=[*CONDITIONS, *HEAVIER],
    )
    study = Study(replace(given, candidates=("edge_wrap", "series_compliance")), THRESHOLDS, seed=3)
    study.lookalikes = ("viscous_drag", "wet_film")
    found = with_pairs(study, [study.weigh(())] + [study.weigh((name,)) for name in study.candidates], 1)
    assert {r.effects for r in found} >= {
        ("series_compliance", "viscous_drag"),
        ("edge_wrap", "series_compliance"),
    }
    weights = probabilities(found, THRESHOLDS)
    verdict = decide(weights, found, THRESHOLDS)
    assert verdict.effects == ("series_compliance",)
    assert "what it leaves looks most like grease or moisture under the strip" in verdict.why
    without = [r for r in found if r.effects != ("series_compliance", "viscous_drag")]
    assert decide(probabilities(without, THRESHOLDS), without, THRESHOLDS).effects == (
        "edge_wrap",
        "series_compliance",
    )


def test_it_speaks_for_unknown_where_it_beats_the_nameless_terms():
    base = weighed((), 0.0)
    assert unknown_as([base], THRESHOLDS) == ""
    assert unknown_as([base, weighed(("wet_film",), 3.0)], THRESHOLDS) == ""
    assert (
        unknown_as([base, weighed(("wet_film",), 30.0), weighed(("lost_area",), 20.0)], THRESHOLDS)
        == "wet_film"
    )


@pytest.fixture(scope="module")
def slow_readout():
    return inputs(("readout_lag",), {"readout_lag.time_constant": 3.5e-4})


def test_a_slow_readout_is_unknown_and_the_sentence_says_what_it_is_like(slow_readout):
    study = Study(slow_readout, THRESHOLDS, seed=3)
    results = [study.weigh(())] + [study.weigh((name,)) for name in study.candidates]
    document = conclude(study, with_pairs(study, results, 0))
    assert document["verdict"]["effects"] == ["unknown"]
    assert "a low pass behind the load cell" in document["verdict"]["why"]
    assert "; model.effects with readout_lag shows what is left" in document["verdict"]["why"]
    assert {row["phase"] for row in document["where"]} >= {"release"}
    said = {name for entry in document["hypotheses"] for name in entry["effects"]}
    assert not said & set(LOOKALIKES)
    assert not {cause["effect"] for cause in document["causes"]} & set(LOOKALIKES)


def test_a_day_with_slow_releases_is_unknown_and_not_what_delays_them():
    given = inputs(("humid_session",), {"humid_session.gain_2": 12.0})
    candidates = ("trapped_charge", "trigger_latency")
    study = Study(replace(given, candidates=candidates), THRESHOLDS, seed=3)
    results = [study.weigh(())] + [study.weigh((name,)) for name in study.candidates]
    document = conclude(study, with_pairs(study, results, 0))
    assert document["verdict"]["effects"] == ["unknown"]
    assert "a humid day" in document["verdict"]["why"]


def test_water_that_the_field_draws_in_is_unknown_and_not_what_attracts_without_it():
    given = inputs(("capillary_bridges",), {"capillary_bridges.pull": 0.4})
    candidates = ("surface_adhesion", "trapped_charge")
    study = Study(replace(given, candidates=candidates), THRESHOLDS, seed=3)
    results = [study.weigh(())] + [study.weigh((name,)) for name in study.candidates]
    document = conclude(study, with_pairs(study, results, 0))
    assert document["verdict"]["effects"] == ["unknown"]
    assert "water drawn in by the field" in document["verdict"]["why"]


def test_where_there_is_nothing_to_name_those_are_weighed_that_promise_something(monkeypatch):
    study = Study(replace(inputs(), candidates=("surface_adhesion", "trapped_charge")), THRESHOLDS, seed=3)
    results = [study.weigh(())] + [study.weigh((name,)) for name in study.candidates]
    assert all(gain < WORTH_A_LOOK for gain in promises(study, study.base, study.lookalikes).values())
    assert with_pairs(study, results, 0) == results
    monkeypatch.setattr("eaclutch.diagnosis.pairs.WORTH_A_LOOK", -1e3)
    found = with_pairs(study, results, 0)
    assert {r.effects for r in found} == {r.effects for r in results} | {(name,) for name in study.lookalikes}
    weights = probabilities(found, THRESHOLDS)
    assert max(weights, key=lambda names: weights[names]) == ()
    assert weights[UNKNOWN] < 0.05


def fits_made(monkeypatch, evidence, tolerance, lead):
    """(name, afresh, seeds) of every fit that weighs lookalikes of such evidence and width beside a lead."""
    made = []

    def weigh(study, fit):
        made.append((*fit.effects, fit.afresh, fit.seeds))
        return SimpleNamespace(
            effects=fit.effects, log_evidence=evidence[fit.effects[0]], multipliers=(tolerance, 1.0),
            named={f"{fit.effects[0]}.size": 2.0},
        )  # fmt: skip

    monkeypatch.setattr("eaclutch.diagnosis.refits.weigh_fit", weigh)
    monkeypatch.setattr("eaclutch.diagnosis.pairs.weigh_fit", weigh)
    study = SimpleNamespace(lookalikes=tuple(evidence), thresholds=THRESHOLDS)
    leading = SimpleNamespace(effects=lead, log_evidence=100.0, named={"k": 3.0})
    _weigh_lookalikes(Spread(study), [leading], lambda result: result.log_evidence, all_of_them=True)
    return made


FROM_THE_LEAD = {"wet_film.size": 2.0, "k": 3.0}


def test_one_near_what_leads_is_fitted_from_there_and_afresh_one_far_behind_is_not(monkeypatch):
    evidence = {"wet_film": 100.0 - NEAR + 1.0, "lost_area": 100.0 - NEAR - 1.0}
    assert fits_made(monkeypatch, evidence, 4.0, ("gap_tilt",)) == [
        ("wet_film", None, None), ("lost_area", None, None),
        ("wet_film", None, FROM_THE_LEAD), ("wet_film", (4.0, 1.0), None),
    ]  # fmt: skip


def test_at_the_usual_tolerances_only_one_close_to_what_leads_is(monkeypatch):
    evidence = {"wet_film": 100.0 - CLOSE + 1.0, "lost_area": 100.0 - CLOSE - 1.0}
    plainly = [("wet_film", None, None), ("lost_area", None, None)]
    assert fits_made(monkeypatch, evidence, 2.0, ("gap_tilt",)) == [
        *plainly, ("wet_film", None, FROM_THE_LEAD),
    ]  # fmt: skip
    # where the base model leads each has been fitted from there
    assert fits_made(monkeypatch, evidence, 2.0, ()) == plainly


def test_one_that_the_model_has_on_does_not_compete(slow_readout):
    study = Study(replace(slow_readout, effects=(*BASE, "readout_lag")), THRESHOLDS, seed=3)
    assert "readout_lag" not in (*study.lookalikes, *study.candidates)


def test_none_is_weighed_by_name(slow_readout):
    with pytest.raises(InputError, match=r"candidates, readout_lag: .* model\.effects"):
        Study(replace(slow_readout, candidates=("gap_tilt", "readout_lag")), THRESHOLDS, seed=3)
