"""Closed forms against refits done the long way."""

import numpy as np
import pytest

from eaclutch.diagnosis.gaussian import Linearised, given, leave_out, log_normal, posterior_mean, posterior_sd


@pytest.fixture
def fit():
    rng = np.random.default_rng(3)
    jacobian = rng.normal(size=(12, 3))
    root = rng.normal(size=(12, 12)) * 0.2
    covariance = root @ root.T + 0.3 * np.eye(12)
    w = jacobian @ rng.normal(size=3) + rng.multivariate_normal(np.zeros(12), covariance)
    return Linearised(w, jacobian, covariance)


GROUPS = [np.array([0, 1, 2]), np.array([3]), np.array([7, 9])]


def test_left_out_density_is_the_conditional_density(fit):
    marginal = fit.marginal()
    found = leave_out(fit, GROUPS)
    for rows, density in zip(GROUPS, found.log_density, strict=True):
        rest = np.setdiff1d(np.arange(12), rows)
        joint, others = log_normal(fit.w, marginal), log_normal(fit.w[rest], marginal[np.ix_(rest, rest)])
        assert density == pytest.approx(joint - others, abs=1e-9)


def test_left_out_prediction_is_that_of_a_refit_without_the_entries(fit):
    found = leave_out(fit, GROUPS)
    for rows, u in zip(GROUPS, found.u, strict=True):
        rest = np.setdiff1d(np.arange(12), rows)
        weight = np.linalg.inv(fit.covariance[np.ix_(rest, rest)])
        jacobian = fit.jacobian[rest]
        refit = np.linalg.solve(jacobian.T @ weight @ jacobian + np.eye(3), jacobian.T @ weight @ fit.w[rest])
        np.testing.assert_allclose(u, refit, atol=1e-9)
        np.testing.assert_allclose(
            (found.prediction_error @ fit.w)[rows], fit.w[rows] - fit.jacobian[rows] @ refit, atol=1e-9
        )


def test_conditional_residual_uses_correlated_neighbours(fit):
    marginal = fit.marginal()
    found = leave_out(fit, GROUPS)
    for rows in GROUPS:
        rest = np.setdiff1d(np.arange(12), rows)
        carried = marginal[np.ix_(rows, rest)] @ np.linalg.solve(marginal[np.ix_(rest, rest)], fit.w[rest])
        np.testing.assert_allclose((found.conditional @ fit.w)[rows], fit.w[rows] - carried, atol=1e-9)


def test_a_held_parameter_is_as_good_as_known(fit):
    # known beforehand, it is taken off the data, and the others are fitted to what is left
    held = given(fit, {1: 0.7})
    np.testing.assert_allclose(held.w, fit.w - 0.7 * fit.jacobian[:, 1])
    np.testing.assert_allclose(held.jacobian, fit.jacobian[:, [0, 2]])
    assert given(fit, {}) is fit


def test_posterior_mean_is_that_of_the_least_squares_with_prior(fit):
    weight = np.linalg.inv(fit.covariance)
    wanted = np.linalg.solve(
        fit.jacobian.T @ weight @ fit.jacobian + np.eye(3), fit.jacobian.T @ weight @ fit.w
    )
    np.testing.assert_allclose(posterior_mean(fit), wanted, atol=1e-9)


def test_posterior_sd_is_that_of_the_least_squares_with_prior(fit):
    hessian = fit.jacobian.T @ np.linalg.solve(fit.covariance, fit.jacobian) + np.eye(3)
    np.testing.assert_allclose(posterior_sd(fit), np.sqrt(np.diag(np.linalg.inv(hessian))), atol=1e-9)
