"""Finalists sampled in full: the evidence of a Gaussian is exact, and what it moves is said."""

import numpy as np
import pytest

from eaclutch.diagnosis.full import document, finalists, importance_evidence
from eaclutch.diagnosis.gaussian import log_normal
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem
from eaclutch.physics.effect import Parameter, Prior

DIAGNOSIS = {
    "hypotheses": [
        {"effects": ["unknown"], "probability": 0.3},
        {"effects": ["gap_tilt"], "probability": 0.4},
        {"effects": [], "probability": 0.1},
        {"effects": ["gap_tilt", "gas_slip"], "probability": 0.2},
    ]
}


def test_the_base_model_and_the_most_probable_names_are_sampled():
    assert finalists(DIAGNOSIS) == [(), ("gap_tilt",), ("gap_tilt", "gas_slip")]
    assert finalists(DIAGNOSIS, most=1) == [(), ("gap_tilt",)]


def test_importance_sampling_finds_the_evidence_of_a_gaussian():
    rng = np.random.default_rng(5)
    jacobian, noise, w = rng.standard_normal((12, 4)), 0.3, rng.standard_normal(12)
    priors = Priors.of(
        [Parameter(f"p{i}", "1", (-50.0, 50.0), 0.0, Prior("normal", 0.0, 1.0)) for i in range(4)]
    )

    def log_likelihood(theta):
        return np.array([log_normal(w - jacobian @ row, noise**2 * np.eye(12)) for row in theta])

    marginal = noise**2 * np.eye(12) + jacobian @ jacobian.T
    mean = jacobian.T @ np.linalg.solve(marginal, w)
    covariance = np.linalg.inv(np.eye(4) + jacobian.T @ jacobian / noise**2)
    draws = mean + rng.standard_normal((4000, 4)) @ np.linalg.cholesky(covariance).T
    found, sd, effective = importance_evidence(Problem("x", priors, log_likelihood), draws, rng)
    assert found == pytest.approx(log_normal(w, marginal), abs=4 * sd + 1e-3)
    assert sd < 0.05 and effective > 1000


def test_probabilities_follow_the_sampled_evidence():
    rows = [
        {"effects": [], "log_evidence": -10.0, "log_evidence_laplace": -10.0},
        {"effects": ["gap_tilt"], "log_evidence": -9.0, "log_evidence_laplace": -9.0 + np.log(4.0)},
    ]
    base, tilt = document(rows, DIAGNOSIS, temperature=1.0)["finalists"]
    assert tilt["probability_laplace"] == pytest.approx(0.8)
    assert tilt["probability"] == pytest.approx(0.5)
    assert base["probability"] == pytest.approx(0.5)
