"""The most probable parameters of a hypothesis: Gauss-Newton with a cheap Jacobian and exact residuals.

The Jacobian is taken on one representative run an entry, the residuals on all runs: repeats
differ in the force at switch-off, which the residuals must follow, but hardly in how a parameter moves them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from eaclutch.diagnosis.forward import Forward
from eaclutch.inference.priors import Priors
from eaclutch.records import FloatArray

STEP = 0.03  # finite differences, in prior sds
DAMPING = np.array(
    [0.0, 0.3, 3.0, 30.0, 300.0]
)  # Levenberg-Marquardt, of the Hessian's diagonal; tried at once
LARGEST_STEP = 3.0  # prior sds a parameter may move at once
ITERATIONS = 20
STEEP = 1.0  # change of an entry per prior sd that is looked at from the other side too
ENOUGH = 0.05  # nats of predicted gain below which a fit ends
LITTLE = 1.0  # nats of predicted gain below which one that had to end has converged


@dataclass(frozen=True)
class Mode:
    """A mode in standard normal prior coordinates ``u`` (params,), with the Jacobian of the data vector there.

    theta (params,): natural units; predicted (entries,); jacobian (entries, params), d prediction / d u; converged.
    """

    priors: Priors
    u: FloatArray
    theta: FloatArray
    predicted: FloatArray
    jacobian: FloatArray
    converged: bool

    @property
    def names(self) -> tuple[str, ...]:
        return self.priors.names


def find_mode(
    forward: Forward,
    values: FloatArray,
    covariance_at: Callable[[FloatArray], FloatArray],
    u: FloatArray,
) -> Mode:
    """Maximise -r' C^-1 r / 2 - u'u / 2 from ``u`` (params,).

    covariance_at(theta) gives C (entries, entries): it holds a share of the effect's own signature, so it is
    worked out again while the fit still moves.
    """
    priors = forward.priors
    predicted = forward.predict(priors.from_normal(u))[0]
    jacobian: FloatArray | None = None
    converged = False
    for iteration in range(ITERATIONS):
        if iteration < 3:
            factor = cho_factor(covariance_at(priors.from_normal(u)), lower=True)
        if jacobian is None:
            jacobian = columns(forward, u)
        weighted = cho_solve(factor, jacobian)
        residual = values - predicted
        hessian = jacobian.T @ weighted + np.eye(len(u))
        gradient = weighted.T @ residual - u
        gain = 0.5 * float(gradient @ np.linalg.solve(hessian, gradient))
        if gain < ENOUGH and iteration > 0:
            converged = True
            break
        trials = u + _steps(hessian, gradient)
        found = forward.predict(priors.from_normal(trials))
        cost = _cost(values - found, trials, factor)
        best = int(np.argmin(cost))
        if cost[best] > _cost(residual[None], u[None], factor)[0] - 1e-3:
            converged = gain < LITTLE
            if iteration > 0:
                break
            continue
        u, predicted, jacobian = trials[best], found[best], None
        converged = gain < LITTLE
    return mode_at(forward, u, predicted, jacobian, converged)


def mode_at(
    forward: Forward, u: FloatArray, predicted: FloatArray, jacobian: FloatArray | None, converged: bool
) -> Mode:
    """The mode that stands at ``u`` (params,): ``predicted`` (entries,), ``jacobian`` where it is known."""
    if jacobian is None:
        jacobian = columns(forward, u)
    return Mode(forward.priors, u, forward.priors.from_normal(u), predicted, jacobian, converged)


def _steps(hessian: FloatArray, gradient: FloatArray) -> FloatArray:
    """Damped Gauss-Newton steps (dampings, params), none longer than LARGEST_STEP in any parameter."""
    diagonal = np.diag(np.diag(hessian))
    steps = np.stack([np.linalg.solve(hessian + d * diagonal, gradient) for d in DAMPING])
    longest = np.max(np.abs(steps), axis=1, keepdims=True)
    return steps * np.minimum(1.0, LARGEST_STEP / np.maximum(longest, 1e-12))


def columns(forward: Forward, u: FloatArray) -> FloatArray:
    """d prediction / d u (entries, params) by forward differences on the representative runs.

    A run on the verge of sticking jumps when a parameter moves; a jump lies on one side only. So a steep slope
    counts only where the other side has it too, and with the smaller size (minmod).
    """
    # away from the prior's far tail, where a step would be lost to the bounds
    step = np.where(u > 4.0, -STEP, STEP)
    points = np.concatenate([u[None], u + np.diag(step)])
    found = forward.representative.predict(forward.priors.from_normal(points))
    slopes = ((found[1:] - found[0]) / step[:, None]).T
    steep = np.flatnonzero(np.any(np.abs(slopes) > STEEP, axis=0))
    if len(steep):
        behind = u - np.diag(step)[steep]
        other = forward.representative.predict(forward.priors.from_normal(behind))
        back = ((found[0] - other) / step[steep, None]).T
        ahead = slopes[:, steep]
        slopes[:, steep] = np.where(np.abs(ahead) > STEEP, gentler(back, ahead), ahead)
    return slopes


def gentler(back: FloatArray, ahead: FloatArray) -> FloatArray:
    """The smaller of two slopes where both have the same sign, else 0 (minmod): a jump lies on one side only."""
    return np.where(back * ahead > 0, np.where(np.abs(back) < np.abs(ahead), back, ahead), 0.0)


def _cost(residual: FloatArray, u: FloatArray, factor: tuple) -> FloatArray:
    white = cho_solve(factor, residual.T)
    return 0.5 * np.sum(residual.T * white, axis=0) + 0.5 * np.sum(u**2, axis=1)
