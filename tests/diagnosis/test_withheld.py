"""Base effects that a model leaves out: likelier beforehand than candidates, and never passed over in silence."""

import json
from dataclasses import replace
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.conclude import conclude
from eaclutch.diagnosis.gaussian import Linearised
from eaclutch.diagnosis.pairs import _beside_the_lead, with_pairs
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.verdict import built_on, decide, leading
from eaclutch.diagnosis.weigh import NONE, UNKNOWN, log_prior, probabilities
from eaclutch.diagnosis.withheld import taken_over, told_by, withheld
from eaclutch.physics.effects import BASE, CANDIDATES


def weighed(effects, evidence):
    return SimpleNamespace(
        effects=effects, log_evidence=evidence, log_evidence_open=-1e3, log_evidence_without=0.0,
        log_evidence_without_open=0.0, log_density=(), gap_left_out=1.0, adequate_p=1.0, multipliers=(1.0, 1.0),
        repeat_drift=0.0, remainder_law=(),
    )  # fmt: skip


def test_what_is_left_out_of_the_model_acts_or_does_not_whatever_else_acts():
    prior, names = load_thresholds()["prior"], (*CANDIDATES, "air_gap")
    odds = np.log(prior["base_odds"])
    for others in ((), ("trigger_latency",), ("edge_wrap", "trigger_latency")):
        alone = log_prior(others, names, prior)
        assert log_prior((*others, "air_gap"), names, prior) == pytest.approx(alone + odds)
        # and whether one more is weighed makes no candidate less likely
        assert log_prior(others, CANDIDATES, prior) == pytest.approx(alone)


def test_by_equal_evidence_what_is_left_out_is_likelier_than_a_candidate():
    sets = [
        NONE,
        ("air_gap",),
        ("trigger_latency",),
        ("air_gap", "edge_wrap"),
        ("edge_wrap", "trigger_latency"),
    ]
    thresholds = load_thresholds()
    odds = thresholds["prior"]["base_odds"]
    found = probabilities([weighed(e, 20.0 if e else 0.0) for e in sets], thresholds)
    assert found[sets[1]] > 50.0 * found[sets[2]]
    assert found[sets[3]] == pytest.approx(odds * found[sets[2]]) and found[sets[3]] > 50.0 * found[sets[4]]


def test_what_parameters_follow_is_taken_over_and_what_they_cannot_is_not():
    jacobian, noise = np.array([[100.0], [0.0], [0.0]]), np.eye(3)
    fit = Linearised(np.zeros(3), jacobian, noise)
    assert taken_over(np.array([5.0, 0.0, 0.0]), fit, noise) == pytest.approx(1.0, abs=1e-3)
    assert taken_over(np.array([0.0, 5.0, 0.0]), fit, noise) == pytest.approx(0.0, abs=1e-9)
    assert taken_over(np.array([5.0, 5.0, 0.0]), fit, noise) == pytest.approx(0.5, abs=1e-3)
    assert taken_over(np.zeros(3), fit, noise) == 0.0


def test_what_nothing_takes_over_is_told_by_half_its_squared_size():
    noise = np.eye(2)
    shift = np.array([3.0, 0.0])
    assert told_by(shift, Linearised(np.zeros(2), np.zeros((2, 1)), noise)) == pytest.approx(4.5)
    # a parameter as wide as the effect, or a tolerance, leaves less of it
    assert told_by(shift, Linearised(np.zeros(2), np.array([[3.0], [0.0]]), noise)) == pytest.approx(0.45)
    assert told_by(shift, Linearised(np.zeros(2), np.zeros((2, 1)), 10.0 * noise)) == pytest.approx(0.45)


def test_a_caveat_says_what_the_model_leaves_out_and_no_verdict_names():
    given = inputs()
    less = replace(given, effects=tuple(e for e in BASE if e != "air_gap"), candidates=("air_gap",))
    study = Study(less, load_thresholds(), seed=3)
    results = [study.weigh(()), study.weigh(("air_gap",))]
    notes = withheld(study, results, UNKNOWN)
    assert len(notes) == 1 and notes[0].startswith("air gap is left out of the model")
    assert "%, and the rest could tell it by" in notes[0]
    assert withheld(study, results, ("air_gap",)) == []
    strength = {"mean": 0.2, "sd": 0.1, "unit": "1"}
    weak = replace(results[1], parameters={"strength": strength})
    assert withheld(study, [results[0], weak], ("air_gap",)) == [
        "the data bear 0.20 +- 0.10 of what the law of air gap says"
    ]
    switch = replace(results[1], parameters={})
    assert withheld(study, [results[0], switch], ("air_gap",)) == []
    strength["sd"] = 0.5  # it may be all of it
    assert withheld(study, [results[0], weak], ("air_gap",)) == []
    whole = Study(given, load_thresholds(), seed=3)
    assert withheld(whole, [whole.weigh(())], NONE) == []


def test_a_switch_that_is_left_out_is_named_and_has_no_strength():
    given = inputs(repeats=2)
    switch = "load_cell_dynamics"
    less = replace(given, effects=tuple(e for e in BASE if e != switch), candidates=(switch,))
    study = Study(less, load_thresholds(), seed=3)
    document = conclude(study, [study.weigh(()), study.weigh((switch,))], campaigns=40)
    assert document["verdict"]["effects"] == [switch] and "the data bear" not in document["verdict"]["why"]


THREE = ("air_gap", "series_compliance", "substrate_inertia")
PAIR = THREE[1:]


def test_a_verdict_names_the_pair_that_three_are_built_on_with_the_probability_of_both():
    thresholds = load_thresholds()
    rows = [weighed(e, 0.0) for e in (NONE, PAIR, THREE)]
    weights = {THREE: 0.6, UNKNOWN: 0.25, PAIR: 0.15, NONE: 0.0}
    verdict = decide(weights, rows, thresholds)
    assert verdict.effects == PAIR and verdict.probability == pytest.approx(0.75)
    assert verdict.alternatives == (THREE, UNKNOWN)
    assert "(probability 0.75, 0.60 of it with air gap beside them)" in verdict.why
    # each of them alone is less probable than what the library lacks, both are not
    weights = {THREE: 0.35, UNKNOWN: 0.4, PAIR: 0.25, NONE: 0.0}
    assert leading(weights) == (PAIR, pytest.approx(0.6))
    assert built_on(PAIR, weights) == [THREE] and built_on(NONE, weights) == built_on(UNKNOWN, weights) == []
    # together they are less probable than what the library lacks
    verdict = decide({THREE: 0.3, UNKNOWN: 0.6, PAIR: 0.1, NONE: 0.0}, rows, thresholds)
    assert verdict.effects == UNKNOWN and verdict.alternatives == (THREE, PAIR)
    assert "beside them" not in verdict.why


def test_three_are_weighed_only_where_a_pair_of_candidates_leads():
    study = SimpleNamespace(thresholds=load_thresholds())
    rows = [weighed(e, 0.0) for e in (NONE, ("air_gap",), PAIR[:1])]
    pair, with_gap = weighed(PAIR, 60.0), weighed(THREE[:2], 60.0)
    assert _beside_the_lead(study, [*rows, pair]) == [(pair, rows[1])]
    assert _beside_the_lead(study, [*rows, pair, with_gap]) == []  # a pair has room for it
    assert _beside_the_lead(study, [*rows, weighed(PAIR[1:], 60.0)]) == []
    assert _beside_the_lead(study, [rows[0], rows[2], pair]) == []  # nothing is left out


def test_what_hardly_acts_does_not_take_the_place_of_a_pair(request):
    sizes = {"series_compliance.compliance": 2.5e-5, "trigger_latency.delay": 3e-4}
    names = ("series_compliance", "trigger_latency")
    given = inputs(names, sizes)
    less = replace(
        given, effects=tuple(e for e in BASE if e != "film_weight"), candidates=("film_weight", *names)
    )
    study = Study(less, load_thresholds(), seed=3)
    singles = [study.weigh(()), *(study.weigh((name,)) for name in study.candidates)]
    found = with_pairs(study, singles, 2)
    assert ("film_weight", *names) in [result.effects for result in found]
    document = json.loads(json.dumps(conclude(study, found, campaigns=40)))
    path = request.config.rootpath / "workflow" / "schemas" / "diagnosis.schema.json"
    jsonschema.validate(document, json.loads(path.read_text()))
    verdict = document["verdict"]
    assert tuple(verdict["effects"]) == names
    both = [e["probability"] for e in document["hypotheses"] if set(e["effects"]) >= set(names)]
    assert verdict["probability"] == pytest.approx(sum(both)) and verdict["probability"] > 0.5
    assert "film weight is left out of the model" in verdict["why"]
