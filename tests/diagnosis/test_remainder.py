"""What a nameless remainder says of a gap must be said of the model, not of the place where its fit ended."""

from __future__ import annotations

import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.fit import fit_hypothesis
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.remainder import with_remainder
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study

LARGE = ("series_compliance", "substrate_inertia")
SIZES = {"series_compliance.compliance": 8e-5, "substrate_inertia.participation": 0.9}


@pytest.fixture(scope="module")
def study() -> Study:
    return Study(inputs(LARGE, SIZES), load_thresholds())


def remainder(study: Study, fitted: HypothesisFit) -> float:
    """Evidence of the base model's remainder beside a fit of it."""
    assert fitted.multipliers[0] > 2.0  # a large gap
    forward = study.forward(())
    return with_remainder(forward, study.data, study.kernels, study.thresholds, fitted).log_evidence


def test_around_a_large_gap_it_does_not_hang_on_where_the_fit_ended(study, monkeypatch):
    """A fit made at usual tolerances bends every parameter before it gives up."""
    monkeypatch.setattr("eaclutch.diagnosis.fit.ROUNDS", 1)
    bent = fit_hypothesis(study.forward(()), study.data, study.kernels, study.thresholds)
    found = remainder(study, study.base)
    assert remainder(study, bent) == pytest.approx(found, abs=3.0)
    monkeypatch.setattr("eaclutch.diagnosis.remainder.ROUNDS", 0)
    assert remainder(study, bent) < found - 5.0
