"""Laplace fits: exact on linear models, good on mildly nonlinear ones, honest when they fail."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from eaclutch.inference import laplace
from eaclutch.physics.effect import Parameter, Prior


def parameter(name: str, prior: Prior, bounds=(-np.inf, np.inf), default=1.0) -> Parameter:
    return Parameter(name, "1", bounds, default, prior)


@pytest.fixture
def linear():
    """y = X theta + unit noise with independent normal priors: everything is known in closed form."""
    rng = np.random.default_rng(1)
    design = rng.standard_normal((12, 3)) * [1.0, 3.0, 0.5]
    data = design @ [0.3, -1.0, 2.0] + rng.standard_normal(12)
    mean, sd = np.array([0.0, 1.0, -1.0]), np.array([2.0, 0.5, 1.5])
    parameters = [parameter(n, Prior("normal", m, s)) for n, m, s in zip("abc", mean, sd, strict=True)]
    return design, data, mean, sd, parameters, (lambda theta: data - theta @ design.T)


def test_linear_model_has_the_closed_form(linear):
    design, data, mean, sd, parameters, residual = linear
    log_norm = -0.5 * 12 * np.log(2 * np.pi)
    found = laplace.fit(residual, parameters, log_norm=log_norm)
    precision = design.T @ design + np.diag(sd**-2)
    expected = np.linalg.solve(precision, design.T @ data + mean / sd**2)
    assert found.converged
    np.testing.assert_allclose(found.mode, expected, rtol=1e-5)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(precision), rtol=1e-5)
    evidence = multivariate_normal(design @ mean, design @ np.diag(sd**2) @ design.T + np.eye(12)).logpdf(
        data
    )
    assert found.log_evidence == pytest.approx(evidence, abs=1e-4)


def test_leaving_out_equals_the_refit_on_a_linear_model(linear):
    design, data, mean, sd, parameters, residual = linear
    rows = np.array([2, 5, 6])
    left = laplace.leave_out(laplace.fit(residual, parameters), rows)
    keep = np.setdiff1d(np.arange(12), rows)
    precision = design[keep].T @ design[keep] + np.diag(sd**-2)
    mode = np.linalg.solve(precision, design[keep].T @ data[keep] + mean / sd**2)
    covariance = design[rows] @ np.linalg.inv(precision) @ design[rows].T
    np.testing.assert_allclose(left.residual, data[rows] - design[rows] @ mode, atol=1e-5)
    np.testing.assert_allclose(left.covariance, covariance, rtol=1e-4)
    density = multivariate_normal(design[rows] @ mode, covariance + np.eye(3)).logpdf(data[rows])
    assert left.log_density == pytest.approx(density, abs=1e-4)


def test_two_calls_an_iteration(linear):
    *_, parameters, residual = linear
    sizes = []

    def counted(theta):
        sizes.append(len(theta))
        return residual(theta)

    found = laplace.fit(counted, parameters)
    assert found.calls == len(sizes) <= 1 + 2 * found.iterations
    assert 6 in sizes  # central differences of three parameters in one batch


def test_nonlinear_model_agrees_with_importance_sampling():
    time = np.linspace(0.1, 3, 30)
    rng = np.random.default_rng(5)
    data = 2.0 * np.exp(-time / 0.8) + 0.05 * rng.standard_normal(30)
    parameters = [
        parameter("amplitude", Prior("lognormal", 1.0, 1.0), (0.0, 50.0)),
        parameter("decay_time", Prior("loguniform", 0.01, 100.0), (0.01, 100.0)),
    ]

    def residual(theta):
        return (data - theta[:, :1] * np.exp(-time / theta[:, 1:])) / 0.05

    found = laplace.fit(residual, parameters)
    check = laplace.importance(found, residual, rng, draws=4000)
    assert found.converged and check.effective_share > 0.5
    assert found.log_evidence == pytest.approx(check.log_evidence, abs=0.1)
    np.testing.assert_allclose(found.mode, check.mean, atol=0.3 * check.sd.max())
    np.testing.assert_allclose(found.sd, check.sd, rtol=0.15)


def test_non_finite_regions_are_walked_around():
    parameters = [parameter("x", Prior("normal", 0.0, 3.0), default=0.1)]

    def residual(theta):
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(theta > 0, (np.log(theta) - 1.0) / 0.1, np.nan)

    found = laplace.fit(residual, parameters)
    assert found.converged
    assert found.mode[0] == pytest.approx(np.e, rel=0.02)
    with pytest.raises(ValueError, match="not finite at the start"):
        laplace.fit(residual, parameters, start=np.array([-1.0]))


def test_too_few_iterations_are_said():
    def residual(theta):  # Rosenbrock: a curved valley
        return np.stack([10 * (theta[:, 1] - theta[:, 0] ** 2), 1 - theta[:, 0]], axis=1) * 20

    parameters = [parameter(n, Prior("normal", 0.0, 5.0), default=d) for n, d in (("x", -1.5), ("y", 2.0))]
    early = laplace.fit(residual, parameters, max_iterations=2)
    assert not early.converged and "predicted gain" in early.message
    late = laplace.fit(residual, parameters, max_iterations=200)
    assert late.converged
    np.testing.assert_allclose(late.mode, 1.0, atol=0.01)
