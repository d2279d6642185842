"""Marginal likelihood of spectra whose sources scatter around the sought dielectric parameters.

For every source the four standardised deviations z ~ N(0, I) of (ln kappa_s, ln tau, alpha, ln kappa_inf) are
integrated by a Laplace approximation around that source's own mode, found by Gauss-Newton: sources differ by more
than a linearisation around their common centre bears (tau by a factor of two and more).
"""

from __future__ import annotations

import numba
import numpy as np

LEVEL_SCALE = np.array([1.0, 2.0, 1.0, 5.0])  # of ln kappa_s, ln tau, alpha, ln kappa_inf, in source_spread
ITERATIONS = 4
LONGEST_STEP = 1.5  # of a Gauss-Newton step, in level sds


@numba.njit(cache=True, nogil=True)
def curve(
    log_omega: np.ndarray, shape: np.ndarray, spread: float, level: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """kappa (points,) and its slopes (points, 4) in the standardised level; ``shape`` holds kappa_s, kappa_inf, tau,
    alpha, beta; ``level`` (4,)."""
    static = shape[0] * np.exp(spread * LEVEL_SCALE[0] * level[0])
    log_tau = np.log(shape[2]) + spread * LEVEL_SCALE[1] * level[1]
    alpha = shape[3] + spread * LEVEL_SCALE[2] * level[2]
    bent = 1.0
    if alpha < 0.05 or alpha > 1.0:  # outside what the law allows: stay at the edge
        alpha, bent = min(max(alpha, 0.05), 1.0), 0.0
    high = shape[1] * np.exp(spread * LEVEL_SCALE[3] * level[3])
    beta, points = shape[4], len(log_omega)
    value, slope = np.empty(points), np.empty((points, 4))
    for i in range(points):
        log_x = (log_omega[i] + log_tau) + 0.5j * np.pi  # ln(i omega tau)
        z = np.exp(alpha * log_x)
        inverse = 1.0 / (1.0 + z) if beta == 1.0 else np.exp(-beta * np.log(1.0 + z))
        outer = -beta * z * inverse / (1.0 + z)
        value[i] = high + (static - high) * inverse.real
        slope[i, 0] = spread * LEVEL_SCALE[0] * static * inverse.real
        slope[i, 1] = spread * LEVEL_SCALE[1] * (static - high) * (outer * alpha).real
        slope[i, 2] = bent * spread * LEVEL_SCALE[2] * (static - high) * (outer * log_x).real
        slope[i, 3] = spread * LEVEL_SCALE[3] * high * (1.0 - inverse.real)
    return value, slope


@numba.njit(cache=True, nogil=True)
def _solve(matrix: np.ndarray, right: np.ndarray) -> float:
    """Solve in place by Cholesky (small matrices); returns the log determinant."""
    size, log_det = len(right), 0.0
    for p in range(size):
        for q in range(p + 1):
            v = matrix[p, q]
            for m in range(q):
                v -= matrix[p, m] * matrix[q, m]
            if p == q:
                matrix[p, p] = np.sqrt(v)
                log_det += np.log(v)
            else:
                matrix[p, q] = v / matrix[q, q]
    for p in range(size):
        v = right[p]
        for m in range(p):
            v -= matrix[p, m] * right[m]
        right[p] = v / matrix[p, p]
    for p in range(size - 1, -1, -1):
        v = right[p]
        for m in range(p + 1, size):
            v -= matrix[m, p] * right[m]
        right[p] = v / matrix[p, p]
    return log_det


@numba.njit(cache=True, nogil=True)
def _source(
    data: np.ndarray,
    log_omega: np.ndarray,
    shape: np.ndarray,
    noise: np.ndarray,
    spread: float,
    level: np.ndarray,
) -> float:
    """Laplace log marginal of one source; its mode is left in ``level``."""
    levels = len(level)
    level[:] = 0.0
    hessian, gradient = np.empty((levels, levels)), np.empty(levels)
    total = -np.inf
    for iteration in range(ITERATIONS + 1):
        mean, slope = curve(log_omega, shape, spread, level)
        fit, norm = 0.0, 0.0
        hessian[:] = np.eye(levels)
        gradient[:] = -level
        for i in range(len(data)):
            gap, n = data[i] - mean[i], noise[i]
            fit += gap * gap / n
            norm += np.log(2 * np.pi * n)
            for p in range(levels):
                gradient[p] += slope[i, p] * gap / n
                for q in range(levels):
                    hessian[p, q] += slope[i, p] * slope[i, q] / n
        log_det = _solve(hessian, gradient)
        total = -0.5 * (fit + norm + np.sum(level**2) + log_det)
        if spread == 0.0:
            break
        if iteration < ITERATIONS:
            longest = np.max(np.abs(gradient))
            if longest < 1e-4:
                break
            level += gradient * min(1.0, LONGEST_STEP / longest)
    return total


@numba.njit(cache=True, nogil=True)
def marginal(
    data: np.ndarray,
    log_omega: np.ndarray,
    starts: np.ndarray,
    shape: np.ndarray,
    noise: np.ndarray,
    spread: np.ndarray,
) -> np.ndarray:
    """Log likelihood (draws,) of data (points,) in sources [starts[j], starts[j+1]); shape (draws, 5), noise variances
    (draws, points), spread (draws,)."""
    draws = len(shape)
    result, level = np.empty(draws), np.zeros(len(LEVEL_SCALE))
    for draw in range(draws):
        total = 0.0
        for j in range(len(starts) - 1):
            a, b = starts[j], starts[j + 1]
            total += _source(data[a:b], log_omega[a:b], shape[draw], noise[draw, a:b], spread[draw], level)
        result[draw] = total if np.isfinite(total) else -np.inf
    return result


@numba.njit(cache=True, nogil=True)
def source_modes(
    data: np.ndarray,
    log_omega: np.ndarray,
    starts: np.ndarray,
    shape: np.ndarray,
    noise: np.ndarray,
    spread: float,
) -> np.ndarray:
    """Most probable standardised levels (sources, 4) of one draw."""
    sources = len(starts) - 1
    modes = np.zeros((sources, len(LEVEL_SCALE)))
    for j in range(sources):
        a, b = starts[j], starts[j + 1]
        _source(data[a:b], log_omega[a:b], shape, noise[a:b], spread, modes[j])
    return modes
