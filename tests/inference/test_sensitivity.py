"""Prior sensitivity and conflict against a conjugate normal, where everything is known."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.inference.priors import Priors
from eaclutch.inference.sensitivity import sensitivity, warnings_of
from eaclutch.physics.effect import Parameter, Prior


def conjugate(data_mean: float, data_sd: float, prior_mean=10.0, prior_sd=2.0, draws=60000):
    """Exact draws of the posterior of a normal mean, and the measures."""
    precision = prior_sd**-2 + data_sd**-2
    mean = (prior_mean * prior_sd**-2 + data_mean * data_sd**-2) / precision
    theta = mean + np.random.default_rng(0).standard_normal((draws, 1)) * precision**-0.5
    u = (theta[:, 0] - prior_mean) / prior_sd
    density = -0.5 * u**2 - 0.5 * ((theta[:, 0] - data_mean) / data_sd) ** 2
    priors = Priors.of([Parameter("x", "1", (-np.inf, np.inf), 0.0, Prior("normal", prior_mean, prior_sd))])
    return sensitivity(priors, theta, density)["x"], mean, precision**-0.5


def test_strong_data_leave_the_prior_no_say():
    row, *_ = conjugate(12.0, 0.1)
    assert row["driven_by"] == "data" and not row["conflict"]
    assert row["contraction"] == pytest.approx(1 - 0.1**2 / (0.1**2 + 4), abs=1e-3)
    assert row["pull"] == pytest.approx(1.0, abs=0.02)


def test_weak_data_are_named():
    row, *_ = conjugate(11.0, 6.0)
    assert row["driven_by"] == "prior"
    assert "driven by the prior: x" in warnings_of({"x": row})[-1]


def test_contradiction_is_named_with_its_pull():
    row, *_ = conjugate(30.0, 1.5)
    assert row["conflict"] and row["driven_by"] == "both"
    # what the data alone say, +- their own and the prior's error: (30 - 10) / hypot(1.5, 2)
    assert row["pull"] == pytest.approx(20 / np.hypot(1.5, 2.0), rel=0.02)
    assert "+8.0 standard errors" in warnings_of({"x": row})[0]


def test_power_scaling_agrees_with_a_prior_that_counts_twice():
    """First order: doubling the prior's weight t times for small t moves the mean as predicted."""
    row, mean, sd = conjugate(13.0, 1.0)
    share = 2.0**0.01
    moved = (10 * share / 4 + 13.0) / (share / 4 + 1.0)
    assert row["prior_sensitivity"] == pytest.approx(abs(moved - mean) / 0.01 / sd, rel=0.03)
    assert row["likelihood_sensitivity"] == pytest.approx(row["prior_sensitivity"], rel=0.05)
