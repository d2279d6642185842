"""Base effects that a model leaves out: likelier beforehand than candidates, and never passed over in silence."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.gaussian import Linearised
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.weigh import NONE, UNKNOWN, log_prior, probabilities
from eaclutch.diagnosis.withheld import taken_over, withheld
from eaclutch.physics.effects import BASE, CANDIDATES


def weighed(effects, evidence):
    return SimpleNamespace(
        effects=effects, log_evidence=evidence, log_evidence_open=-1e3, log_evidence_without=0.0,
        log_evidence_without_open=0.0, gap_left_out=1.0, adequate_p=1.0, multipliers=(1.0, 1.0), repeat_drift=0.0,
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
    found = probabilities([weighed(e, 20.0 if e else 0.0) for e in sets], load_thresholds())
    assert found[sets[1]] > 100.0 * found[sets[2]]
    assert found[sets[3]] == pytest.approx(found[sets[2]]) and found[sets[3]] > 100.0 * found[sets[4]]


def test_what_parameters_follow_is_taken_over_and_what_they_cannot_is_not():
    jacobian, noise = np.array([[100.0], [0.0], [0.0]]), np.eye(3)
    fit = Linearised(np.zeros(3), jacobian, noise)
    assert taken_over(np.array([5.0, 0.0, 0.0]), fit, noise) == pytest.approx(1.0, abs=1e-3)
    assert taken_over(np.array([0.0, 5.0, 0.0]), fit, noise) == pytest.approx(0.0, abs=1e-9)
    assert taken_over(np.array([5.0, 5.0, 0.0]), fit, noise) == pytest.approx(0.5, abs=1e-3)
    assert taken_over(np.zeros(3), fit, noise) == 0.0


def test_a_caveat_says_what_the_model_leaves_out_and_no_verdict_names():
    given = inputs()
    less = replace(given, effects=tuple(e for e in BASE if e != "air_gap"), candidates=("air_gap",))
    study = Study(less, load_thresholds(), seed=3)
    results = [study.weigh(()), study.weigh(("air_gap",))]
    notes = withheld(study, results, UNKNOWN)
    assert len(notes) == 1 and notes[0].startswith("air gap is left out of the model")
    assert notes[0].endswith("%")
    assert withheld(study, results, ("air_gap",)) == []
    whole = Study(given, load_thresholds(), seed=3)
    assert withheld(whole, [whole.weigh(())], NONE) == []
