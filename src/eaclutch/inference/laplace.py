"""Gauss-Newton / Laplace fits of a residual function whose leading axis is draws.

Minimises 0.5 r(theta)'r(theta) + 0.5 u'u, where u are the standard normal coordinates of the prior
(`priors.Priors`): the second term *is* the prior. All finite-difference columns are evaluated in one
batched call of the residual function, all damping trials in another.

The evidence is that of the same quadratic form (MacKay 1992, doi:10.1162/neco.1992.4.3.415):
log Z = log L(mode) - 0.5 u'u - 0.5 log det(1 + J'J), since prior and Laplace normalisations cancel in u.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.special import gammaln

from eaclutch.inference.priors import Priors
from eaclutch.physics.effect import Parameter
from eaclutch.records import FloatArray

Residual = Callable[[FloatArray], FloatArray]
"""(draws, params) in natural units -> (draws, residuals), whitened (each of unit variance); non-finite
values mark parameter vectors that cannot be evaluated."""

DAMPING_TRIALS = np.array([0.0, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 1e3])
STEP_IN_SD = 0.05  # finite-difference step, in conditional posterior sds
STEP_LIMITS = (1e-6, 1e-2)  # in prior sds


@dataclass(frozen=True)
class LaplaceFit:
    """A mode and the Gaussian around it.

    mode, sd (params,), covariance (params, params): natural units, by the delta method.
    u_mode, u_covariance: in standard normal prior coordinates, where the Gaussian is meant.
    residual (residuals,) and jacobian d r / d u (residuals, params) at the mode.
    log_likelihood at the mode, log_evidence (both with ``log_norm``), iterations, calls of the residual
    function, decrement (predicted remaining gain, nats), converged, message (advice where it is not).
    """

    priors: Priors
    mode: FloatArray
    covariance: FloatArray
    u_mode: FloatArray
    u_covariance: FloatArray
    residual: FloatArray
    jacobian: FloatArray
    log_likelihood: float
    log_evidence: float
    iterations: int
    calls: int
    decrement: float
    converged: bool
    message: str = ""

    @property
    def names(self) -> tuple[str, ...]:
        return self.priors.names

    @property
    def sd(self) -> FloatArray:
        return np.sqrt(np.diag(self.covariance))

    def draws(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Draws (n, params) in natural units from the Gaussian in u."""
        return self.priors.from_normal(self.u_draws(rng, n))

    def u_draws(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Draws (n, params) in standard normal coordinates."""
        root = np.linalg.cholesky(self.u_covariance)
        return self.u_mode + rng.standard_normal((n, len(self.priors))) @ root.T


def fit(
    residual: Residual,
    parameters: Sequence[Parameter] | Priors,
    *,
    start: FloatArray | None = None,
    log_norm: float = 0.0,
    max_iterations: int = 50,
    tolerance: float = 1e-4,
) -> LaplaceFit:
    """Find the mode by damped Gauss-Newton and return the Laplace approximation around it.

    ``start`` (params,) in natural units (default: the parameters' defaults). ``log_norm`` is the sum of the
    residuals' log normalisations (-sum log sd - n/2 log 2 pi). Converged: the predicted remaining gain is
    below ``tolerance`` nats, or no damping improves while it is below 100 x that (finite-difference floor).
    Raises ValueError where the start itself cannot be evaluated.
    """
    priors = parameters if isinstance(parameters, Priors) else Priors.of(parameters)
    theta0 = np.array([p.default for p in priors.parameters]) if start is None else np.asarray(start, float)
    u = priors.to_normal(theta0)
    size = len(priors)
    r = np.asarray(residual(priors.from_normal(u[None])), dtype=float)[0]
    if not np.all(np.isfinite(r)):
        raise ValueError(
            f"the residuals are not finite at the start {dict(zip(priors.names, theta0, strict=True))}"
        )
    calls, cost = 1, 0.5 * (r @ r + u @ u)
    step = np.full(size, 1e-3)
    damping, decrement, stuck, iteration = 1.0, np.inf, False, 0
    jacobian = np.zeros((len(r), size))
    for iteration in range(1, max_iterations + 1):  # noqa: B007
        jacobian = _jacobian(residual, priors, u, r, step)
        calls += 1
        hessian = jacobian.T @ jacobian + np.eye(size)
        gradient = jacobian.T @ r + u
        decrement = 0.5 * float(gradient @ np.linalg.solve(hessian, gradient))
        step = np.clip(STEP_IN_SD / np.sqrt(np.diag(hessian)), *STEP_LIMITS)
        if decrement < tolerance:
            break
        trials = np.stack(
            [
                u - np.linalg.solve(hessian + d * damping * np.diag(np.diag(hessian)), gradient)
                for d in DAMPING_TRIALS
            ]
        )
        r_trials = np.asarray(residual(priors.from_normal(trials)), dtype=float)
        calls += 1
        with np.errstate(over="ignore", invalid="ignore"):
            costs = 0.5 * (np.sum(r_trials**2, axis=1) + np.sum(trials**2, axis=1))
        costs = np.where(np.isfinite(costs), costs, np.inf)
        best = int(np.argmin(costs))
        if costs[best] >= cost:
            if stuck or damping > 1e6:
                break
            damping, stuck = damping * 1e3, damping > 1e3
            continue
        stuck = False
        damping = float(np.clip(damping * (0.1 if best <= 1 else 1.0 if best <= 4 else 10.0), 1e-3, 1e6))
        u, r, cost = trials[best], r_trials[best], float(costs[best])
    converged = decrement < 100 * tolerance
    message = "" if converged else (
        f"stopped after {iteration} iterations with a predicted gain of {decrement:.2g} nats left; "
        "start elsewhere or widen the bounds"
    )  # fmt: skip
    return _finish(priors, u, r, jacobian, log_norm, iteration, calls, decrement, converged, message)


def _jacobian(
    residual: Residual, priors: Priors, u: FloatArray, r: FloatArray, step: FloatArray
) -> FloatArray:
    """d r / d u (residuals, params): central differences, one-sided where one side cannot be evaluated."""
    size = len(u)
    shifts = np.concatenate([np.diag(step), -np.diag(step)])
    values = np.asarray(residual(priors.from_normal(u + shifts)), dtype=float)
    above, below = values[:size], values[size:]
    up, down = np.isfinite(above).all(axis=1), np.isfinite(below).all(axis=1)
    above, below = np.where(up[:, None], above, r), np.where(down[:, None], below, r)
    span = step * (up.astype(float) + down.astype(float))
    return ((above - below) / np.where(span > 0, span, 1.0)[:, None]).T


def _finish(
    priors: Priors,
    u: FloatArray,
    r: FloatArray,
    jacobian: FloatArray,
    log_norm: float,
    iterations: int,
    calls: int,
    decrement: float,
    converged: bool,
    message: str,
) -> LaplaceFit:
    hessian = jacobian.T @ jacobian + np.eye(len(u))
    factor = cho_factor(hessian, lower=True)
    u_covariance = cho_solve(factor, np.eye(len(u)))
    slope = priors.slope(u)
    log_likelihood = float(-0.5 * (r @ r) + log_norm)
    log_evidence = log_likelihood - 0.5 * float(u @ u) - float(np.sum(np.log(np.diag(factor[0]))))
    return LaplaceFit(
        priors, priors.from_normal(u), slope[:, None] * u_covariance * slope, u, u_covariance, r, jacobian,
        log_likelihood, log_evidence, iterations, calls, decrement, converged, message,
    )  # fmt: skip


@dataclass(frozen=True)
class LeftOut:
    """Linearised refit without some residuals: their prediction from all the others.

    residual (rows,) mean of the left-out residuals after the refit, covariance (rows, rows) of that mean's
    parameter uncertainty (the measurement's own unit variance is not in it), u_mode (params,) of the refit,
    log_density: of the left-out data, N(0; residual, covariance + 1), without ``log_norm``.
    """

    residual: FloatArray
    covariance: FloatArray
    u_mode: FloatArray
    log_density: float


def leave_out(fit_: LaplaceFit, rows: FloatArray) -> LeftOut:
    """Predict the residuals at ``rows`` (indices or mask) from a fit without them, by one Newton step.

    Exact for linear models. Needs no call of the residual function; with 20 conditions this replaces 20 refits.
    """
    index = np.arange(len(fit_.residual))[rows]
    keep = np.setdiff1d(np.arange(len(fit_.residual)), index)
    jac, res = fit_.jacobian[keep], fit_.residual[keep]
    hessian = jac.T @ jac + np.eye(len(fit_.priors))
    shift = -np.linalg.solve(hessian, jac.T @ res + fit_.u_mode)
    out = fit_.jacobian[index]
    mean = fit_.residual[index] + out @ shift
    covariance = out @ np.linalg.solve(hessian, out.T)
    total = np.linalg.cholesky(covariance + np.eye(len(index)))
    white = solve_triangular(total, mean, lower=True)
    log_density = float(
        -0.5 * white @ white - np.sum(np.log(np.diag(total))) - 0.5 * len(index) * np.log(2 * np.pi)
    )
    return LeftOut(mean, covariance, fit_.u_mode + shift, log_density)


@dataclass(frozen=True)
class Importance:
    """Check of a Laplace fit by importance sampling: log_evidence and its sd, effective share of the draws
    (near 1: the Gaussian is the posterior; below 0.1: do not trust it), natural-unit mean and sd (params,)."""

    log_evidence: float
    log_evidence_sd: float
    effective_share: float
    mean: FloatArray
    sd: FloatArray


def importance(
    fit_: LaplaceFit, residual: Residual, rng: np.random.Generator, *, draws: int = 200, log_norm: float = 0.0
) -> Importance:
    """Reweight draws of the Gaussian (widened to a Student t with 8 degrees of freedom) to the posterior."""
    dof, size = 8.0, len(fit_.priors)
    root = np.linalg.cholesky(fit_.u_covariance)
    normal = rng.standard_normal((draws, size))
    scale = np.sqrt(dof / rng.chisquare(dof, draws))
    white = normal * scale[:, None]
    u = fit_.u_mode + white @ root.T
    values = np.asarray(residual(fit_.priors.from_normal(u)), dtype=float)
    with np.errstate(over="ignore", invalid="ignore"):
        target = -0.5 * np.sum(values**2, axis=1) + log_norm
    target = np.where(np.isfinite(target), target, -np.inf)
    target = target - 0.5 * np.sum(u**2, axis=1) - 0.5 * size * np.log(2 * np.pi)
    log_weights = target - _log_student(white, dof) + np.sum(np.log(np.diag(root)))
    top = float(np.max(log_weights))
    weights = np.exp(log_weights - top)
    share = float(weights.sum() ** 2 / np.sum(weights**2) / draws)
    error = float(np.std(weights) / np.mean(weights) / np.sqrt(draws))
    theta = fit_.priors.from_normal(u)
    normed = weights / weights.sum()
    mean = normed @ theta
    sd = np.sqrt(normed @ (theta - mean) ** 2)
    return Importance(top + float(np.log(np.mean(weights))), error, share, mean, sd)


def _log_student(white: FloatArray, dof: float) -> FloatArray:
    """Log density of the standard multivariate Student t at ``white`` (draws, params)."""
    size = white.shape[1]
    norm = gammaln((dof + size) / 2) - gammaln(dof / 2) - 0.5 * size * np.log(dof * np.pi)
    return norm - 0.5 * (dof + size) * np.log1p(np.sum(white**2, axis=1) / dof)
