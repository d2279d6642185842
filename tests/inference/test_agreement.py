"""emcee and nested sampling on one posterior: they agree where they should, and a wrong chain would show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eaclutch.inference.agreement import agreement, nested
from eaclutch.inference.convergence import Thresholds
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem
from eaclutch.inference.sampling import SamplerSettings
from eaclutch.physics.effect import Parameter, Prior


@pytest.fixture(scope="module")
def curved() -> Problem:
    """Two parameters of which only the product is known well, one with a lognormal prior."""
    priors = Priors.of(
        [
            Parameter("a", "1", (0.0, np.inf), 1.0, Prior("lognormal", 1.0, 0.5)),
            Parameter("b", "1", (-np.inf, np.inf), 1.0, Prior("normal", 1.0, 0.5)),
        ]
    )

    def log_likelihood(theta):
        product, a = theta[:, 0] * theta[:, 1], theta[:, 0]
        return -0.5 * ((product - 1.5) / 0.2) ** 2 - 0.5 * ((a - 1.2) / 0.3) ** 2

    return Problem("made", priors, log_likelihood)


def test_both_samplers_agree(curved):
    settings = SamplerSettings(
        ensembles=2, walkers=24, check_every=300, warm_up=150, thresholds=Thresholds(r_hat=1.03)
    )
    found = agreement(curved, settings, 3, effective=1500)
    assert found["passed"], found
    assert min(found["effective_draws"], found["effective_draws_nested"]) >= 1500


def test_a_posterior_that_is_too_narrow_would_show(curved):
    mean, sd, count = nested(curved, 3, 200)
    narrow = replace(curved, log_likelihood=lambda theta: 3.0 * curved.log_likelihood(theta))
    _, other, _ = nested(narrow, 3, 200)
    assert count > 300 and np.all(np.abs(mean) < 1.5)
    assert np.max(np.abs(other / sd - 1)) > 0.1
