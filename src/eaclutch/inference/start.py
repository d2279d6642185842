"""Where walkers start: around a mode, wider than the posterior, each ensemble from its own search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from eaclutch.records import FloatArray

PRIOR_DRAWS = 400  # from which each search takes its best
OVERDISPERSION = 1.5  # of the start, in posterior sds
STEP = 1e-4


@dataclass(frozen=True)
class Start:
    walkers: FloatArray  # (walkers, params) in normal coordinates, all of finite density
    mode: FloatArray
    root: FloatArray  # Cholesky root of the covariance at the mode
    density: float  # log density at the mode
    evaluations: int


def starting_walkers(
    log_density: Callable[[FloatArray], FloatArray],
    size: int,
    walkers: int,
    rng: np.random.Generator,
    begin: FloatArray | None = None,
) -> Start:
    """Search a mode from the best of some prior draws (or from ``begin``), then spread walkers around it.

    All finite-difference columns of the gradient are one batched call. Raises ValueError where no prior draw
    has a finite density.
    """
    evaluations = 0

    def density(u: FloatArray) -> FloatArray:
        nonlocal evaluations
        evaluations += len(u)
        return log_density(u)

    trial = rng.standard_normal((PRIOR_DRAWS, size))
    values = density(trial)
    if not np.any(np.isfinite(values)):
        raise ValueError("no draw from the prior has a finite likelihood")
    eye = np.eye(size)

    def cost(u: FloatArray) -> tuple[float, FloatArray]:
        batch = density(np.concatenate([u[None], u + STEP * eye, u - STEP * eye]))
        batch = np.where(np.isfinite(batch), batch, -1e12)
        return -float(batch[0]), -(batch[1 : size + 1] - batch[size + 1 :]) / (2 * STEP)

    best = trial[np.argmax(np.where(np.isfinite(values), values, -np.inf))] if begin is None else begin
    found = minimize(cost, best, jac=True, method="L-BFGS-B", options={"maxiter": 200})
    covariance = _covariance(density, found.x)
    root: FloatArray = np.asarray(np.linalg.cholesky(covariance))
    placed = found.x + OVERDISPERSION * rng.standard_normal((walkers, size)) @ root.T
    for _ in range(60):  # pull walkers of no density towards the mode
        lost = ~np.isfinite(density(placed))
        if not lost.any():
            break
        placed[lost] = found.x + 0.7 * (placed[lost] - found.x)
    return Start(placed, found.x, root, -float(found.fun), evaluations)


def _covariance(density: Callable[[FloatArray], FloatArray], u: FloatArray) -> FloatArray:
    """Inverse of the negative Hessian at ``u``, eigenvalues kept within [1e-8, 1] (the prior's variance is 1)."""
    size = len(u)
    step = np.full(size, 1e-3)
    for _ in range(2):  # second pass with steps of about a tenth of the conditional posterior sd
        hessian = _hessian(density, u, step)
        curvature = np.maximum(np.diag(hessian), 1.0)
        step = np.clip(0.1 / np.sqrt(curvature), 1e-5, 0.1)
    values, vectors = np.linalg.eigh(hessian)
    variances = 1.0 / np.clip(values, 1.0, 1e8)
    return (vectors * variances) @ vectors.T


def _hessian(density: Callable[[FloatArray], FloatArray], u: FloatArray, step: FloatArray) -> FloatArray:
    size = len(u)
    eye = np.diag(step)
    points = [
        u + a * eye[i] + b * eye[j]
        for i in range(size)
        for j in range(size)
        for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1))
    ]
    values = density(np.array(points)).reshape(size, size, 4)
    values = np.where(np.isfinite(values), values, np.min(values[np.isfinite(values)], initial=-1e12))
    mixed = values[..., 0] - values[..., 1] - values[..., 2] + values[..., 3]
    hessian = -mixed / (4 * np.outer(step, step))
    return 0.5 * (hessian + hessian.T)
