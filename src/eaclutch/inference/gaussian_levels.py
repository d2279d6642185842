"""Gaussian likelihood of residuals with two nested levels and one shared offset, all marginalised.

Residuals r (draws, points) of trials within widths:

    r_i = s_i (phi_i . (trial_sd a_t + width_sd b_w) + o) + noise_i,   a, b ~ N(0, I), o ~ N(0, offset_sd^2)

The rows phi_i of a fixed basis make the levels curves: phi phi' is a constant plus a smooth kernel over a position.
Trials, then widths, then the offset are integrated out one after the other in the basis' dimension (about ten), so
a draw costs some ten microseconds and grows linearly with the readings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from eaclutch.records import FloatArray

NEGLIGIBLE = 1e-5  # of the smooth kernel's largest eigenvalue


@dataclass(frozen=True)
class LevelDesign:
    """order (points,): points sorted by width, then trial; trial_starts (trials + 1,) in that order;
    trial_width (trials,): each trial's width; basis (points, size) sorted, its first column constant."""

    order: np.ndarray
    trial_starts: np.ndarray
    trial_width: np.ndarray
    basis: FloatArray

    @classmethod
    def of(
        cls, position: FloatArray, width: FloatArray, trial: np.ndarray, constant: float, length: float
    ) -> LevelDesign:
        """``position`` (points,) is what the levels are smooth in; kernel = constant + (1 - constant) exp(-d^2/2)
        with d in units of ``length``, by its leading eigenvectors."""
        _, wide = np.unique(width, return_inverse=True)
        pairs, label = np.unique(
            np.stack([wide, np.unique(trial, return_inverse=True)[1]], axis=1), axis=0, return_inverse=True
        )
        label = label.reshape(-1)
        order = np.argsort(label, kind="stable")
        distance = (position[order][:, None] - position[order][None, :]) / length
        values, vectors = np.linalg.eigh((1 - constant) * np.exp(-0.5 * distance**2))
        kept = values > NEGLIGIBLE * values[-1]
        basis = np.column_stack(
            [np.full(len(position), constant**0.5), vectors[:, kept] * np.sqrt(values[kept])]
        )
        starts = np.concatenate([[0], np.cumsum(np.bincount(label))])
        return cls(order, starts, pairs[:, 0].copy(), np.ascontiguousarray(basis))


@dataclass(frozen=True)
class Levels:
    """Terms of the model, all with draws leading: sensitivity s and noise variance (draws, points), width_sd and
    trial_sd (draws,); offset_sd is one number."""

    sensitivity: FloatArray
    noise: FloatArray
    width_sd: FloatArray
    trial_sd: FloatArray
    offset_sd: float


def marginal(
    residual: FloatArray, levels: Levels, design: LevelDesign
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log likelihood (draws,), and mean and variance (draws,) of the offset given the residuals (draws, points)."""
    order = design.order
    return _marginal(
        residual[:, order], levels.sensitivity[:, order], levels.noise[:, order],
        levels.width_sd**2, levels.trial_sd**2, levels.offset_sd**2,
        design.trial_starts, design.trial_width, design.basis,
    )  # fmt: skip


@numba.njit(cache=True, nogil=True)
def _absorb(
    gram: np.ndarray, right: np.ndarray, variance: float, inner: np.ndarray, gain: np.ndarray
) -> float:
    """Integrate out a level x ~ N(0, variance I) whose information is ``gram``, ``right``; both become the
    information that is left about what x adds to. Returns log det - quadratic gain, to be added to -2 log L."""
    size = len(right)
    log_det = 0.0
    for p in range(size):  # Cholesky of I + variance gram
        for q in range(p + 1):
            v = variance * gram[p, q] + (1.0 if p == q else 0.0)
            for m in range(q):
                v -= inner[p, m] * inner[q, m]
            if p == q:
                inner[p, p] = np.sqrt(v)
                log_det += np.log(v)
            else:
                inner[p, q] = v / inner[q, q]
    for p in range(size):  # forward solves with gram and right
        for q in range(size):
            v = gram[p, q]
            for m in range(p):
                v -= inner[p, m] * gain[m, q]
            gain[p, q] = v / inner[p, p]
        v = right[p]
        for m in range(p):
            v -= inner[p, m] * gain[m, size]
        gain[p, size] = v / inner[p, p]
    quadratic = 0.0
    for p in range(size):
        quadratic += variance * gain[p, size] ** 2
    for p in range(size):  # (I + v G)^-1 right = right - v gain' gain_r;  G (I + v G)^-1 = G - v gain' gain
        for m in range(size):
            right[p] -= variance * gain[m, p] * gain[m, size]
        for q in range(size):
            for m in range(size):
                gram[p, q] -= variance * gain[m, p] * gain[m, q]
    return log_det - quadratic


@numba.njit(cache=True, nogil=True)
def _marginal(residual, sensitivity, noise, wide, trial, offset, starts, widths, basis):  # type: ignore[no-untyped-def]
    draws, points = residual.shape
    size, trials = basis.shape[1], len(widths)
    likelihood, mean, variance = np.empty(draws), np.empty(draws), np.empty(draws)
    gram, right = np.empty((size, size)), np.empty(size)
    gram_width, right_width = np.empty((size, size)), np.empty(size)
    inner, gain, row = np.empty((size, size)), np.empty((size, size + 1)), np.empty(size)
    first = basis[0, 0]  # the constant column: the offset's direction
    for draw in range(draws):
        total, rv, vv = points * np.log(2 * np.pi), 0.0, 0.0
        for t in range(trials):
            if t == 0 or widths[t] != widths[t - 1]:
                gram_width[:], right_width[:] = 0.0, 0.0
            gram[:], right[:] = 0.0, 0.0
            for i in range(starts[t], starts[t + 1]):
                n, r = noise[draw, i], residual[draw, i]
                total += r * r / n + np.log(n)
                for p in range(size):
                    row[p] = sensitivity[draw, i] * basis[i, p]
                for p in range(size):
                    right[p] += row[p] * r / n
                    for q in range(p + 1):
                        gram[p, q] += row[p] * row[q] / n
            for p in range(size):
                for q in range(p):
                    gram[q, p] = gram[p, q]
            total += _absorb(gram, right, trial[draw], inner, gain)
            gram_width += gram
            right_width += right
            if t == trials - 1 or widths[t + 1] != widths[t]:
                total += _absorb(gram_width, right_width, wide[draw], inner, gain)
                rv += right_width[0] / first
                vv += gram_width[0, 0] / first**2
        spread = 1.0 + offset * vv
        value = -0.5 * (total + np.log(spread) - offset * rv * rv / spread)
        likelihood[draw] = value if np.isfinite(value) else -np.inf
        mean[draw], variance[draw] = offset * rv / spread, offset / spread
    return likelihood, mean, variance


def covariance(levels: Levels, draw: int, design: LevelDesign) -> FloatArray:
    """Dense covariance (points, points) of one draw, in the design's sorted order: the definition."""
    order = design.order
    trial = np.repeat(np.arange(len(design.trial_width)), np.diff(design.trial_starts))
    width = design.trial_width[trial]
    same_trial, same_width = trial[:, None] == trial[None, :], width[:, None] == width[None, :]
    curves = levels.width_sd[draw] ** 2 * same_width + levels.trial_sd[draw] ** 2 * same_trial
    kernel = design.basis @ design.basis.T
    s = levels.sensitivity[draw, order]
    return np.outer(s, s) * (kernel * curves + levels.offset_sd**2) + np.diag(levels.noise[draw, order])


def pointwise(residual: FloatArray, levels: Levels, design: LevelDesign) -> FloatArray:
    """Log density (draws, points) of each residual given all the others (Burkner et al. 2021,
    doi:10.1007/s00180-020-01045-4): normal with precision Q_ii and deviation [Q r]_i / Q_ii."""
    order = design.order
    weight, product = _precision(
        residual[:, order], levels.sensitivity[:, order], levels.noise[:, order],
        levels.width_sd, levels.trial_sd, levels.offset_sd,
        design.trial_starts, design.trial_width, design.basis,
    )  # fmt: skip
    result = np.empty_like(residual)
    result[:, order] = 0.5 * np.log(weight / (2 * np.pi)) - 0.5 * product**2 / weight
    return result


@numba.njit(cache=True, nogil=True)
def _precision(residual, sensitivity, noise, wide, trial, offset, starts, widths, basis):  # type: ignore[no-untyped-def]
    """Diagonal of the precision Q and Q r, both (draws, points): Q = N^-1 - N^-1 U (I + U' N^-1 U)^-1 U' N^-1."""
    draws, points = residual.shape
    size, trials = basis.shape[1], len(widths)
    columns = size * (trials + widths[-1] + 1) + 1
    diagonal, product = np.empty((draws, points)), np.empty((draws, points))
    scaled = np.empty((points, columns))
    for draw in range(draws):
        scaled[:] = 0.0
        for t in range(trials):
            for i in range(starts[t], starts[t + 1]):
                weight = sensitivity[draw, i] / np.sqrt(noise[draw, i])
                at_width = size * (trials + widths[t])
                for p in range(size):
                    scaled[i, size * t + p] = weight * basis[i, p] * trial[draw]
                    scaled[i, at_width + p] = weight * basis[i, p] * wide[draw]
                scaled[i, columns - 1] = weight * offset
        lower = np.linalg.cholesky(scaled.T @ scaled + np.eye(columns))
        half = np.linalg.solve(lower, scaled.T.copy())  # (columns, points)
        white = residual[draw] / np.sqrt(noise[draw])
        moved = half @ white
        for i in range(points):
            inside, along = 0.0, 0.0
            for m in range(columns):
                inside += half[m, i] ** 2
                along += half[m, i] * moved[m]
            diagonal[draw, i] = (1.0 - inside) / noise[draw, i]
            product[draw, i] = (white[i] - along) / np.sqrt(noise[draw, i])
    return diagonal, product


def replicate(levels: Levels, design: LevelDesign, rng: np.random.Generator) -> FloatArray:
    """New residuals (draws, points): other trials, other widths' levels, another offset."""
    draws, points = levels.noise.shape
    trials, size = len(design.trial_width), design.basis.shape[1]
    trial = np.repeat(np.arange(trials), np.diff(design.trial_starts))
    own = levels.trial_sd[:, None, None] * rng.standard_normal((draws, trials, size))
    shared = levels.width_sd[:, None, None] * rng.standard_normal((draws, design.trial_width.max() + 1, size))
    curves = np.einsum("pq,dpq->dp", design.basis, own[:, trial] + shared[:, design.trial_width[trial]])
    curves += levels.offset_sd * rng.standard_normal((draws, 1))
    result = np.empty((draws, points))
    result[:, design.order] = curves
    return levels.sensitivity * result + np.sqrt(levels.noise) * rng.standard_normal((draws, points))
