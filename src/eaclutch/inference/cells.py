"""Gaussian likelihood of runs with session and condition levels and a few common factors, cell by cell.

A cell is a (condition, session). Residuals of run r in cell c: e_r = factors + session + condition + noise_r. With the
factors' weights averaged over a cell, the cell's precision-weighted mean and the scatter around it say all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np

from eaclutch.records import FloatArray


@dataclass(frozen=True)
class Cells:
    """cell, session, condition: index (runs,); cell_session, cell_condition: index (cells,)."""

    cell: np.ndarray
    session: np.ndarray
    condition: np.ndarray
    cell_session: np.ndarray
    cell_condition: np.ndarray

    @classmethod
    def of(cls, session: Sequence[str], condition: Sequence[str]) -> Cells:
        _, s = np.unique(np.array(session), return_inverse=True)
        _, c = np.unique(np.array(condition), return_inverse=True)
        pairs, cell = np.unique(np.stack([c, s], axis=1), axis=0, return_inverse=True)
        return cls(cell.reshape(-1), s, c, pairs[:, 1].copy(), pairs[:, 0].copy())

    @property
    def count(self) -> int:
        return len(self.cell_session)

    @property
    def sessions(self) -> int:
        return int(self.session.max()) + 1

    @property
    def conditions(self) -> int:
        return int(self.condition.max()) + 1

    @property
    def same_session(self) -> FloatArray:
        return (self.session[:, None] == self.session[None, :]).astype(float)

    @property
    def same_condition(self) -> FloatArray:
        return (self.condition[:, None] == self.condition[None, :]).astype(float)


def cell_likelihood(
    residual: FloatArray, factors: FloatArray, variance: FloatArray, session_sd: FloatArray, condition_sd: FloatArray,
    cells: Cells,
) -> FloatArray:  # fmt: skip
    """Log likelihood (draws,) of residuals (draws, runs) with factors (draws, factors, runs), variances (draws, runs)
    and level sds (draws,)."""
    return _likelihood(
        np.ascontiguousarray(residual), np.ascontiguousarray(factors), np.ascontiguousarray(variance),
        session_sd**2, condition_sd**2, cells.cell, cells.cell_session, cells.cell_condition,
    )  # fmt: skip


@numba.njit(cache=True, nogil=True)
def _likelihood(residual, factors, variance, session, condition, cell, cell_session, cell_condition):  # type: ignore[no-untyped-def]
    draws, runs = residual.shape
    count, rank = len(cell_session), factors.shape[1]
    result = np.empty(draws)
    weight, mean = np.empty(count), np.empty(count)
    loads, lower, y = np.empty((rank, count)), np.empty((count, count)), np.empty(count)
    for draw in range(draws):
        weight[:], mean[:], loads[:] = 0.0, 0.0, 0.0
        total = 0.0
        for run in range(runs):
            precision, c = 1.0 / variance[draw, run], cell[run]
            weight[c] += precision
            mean[c] += precision * residual[draw, run]
            total += np.log(2 * np.pi * variance[draw, run]) + precision * residual[draw, run] ** 2
            for q in range(rank):
                loads[q, c] += precision * factors[draw, q, run]
        for c in range(count):
            mean[c] /= weight[c]
            total -= weight[c] * mean[c] ** 2 - np.log(weight[c])  # within the cell
            for q in range(rank):
                loads[q, c] /= weight[c]
        for i in range(count):
            for j in range(i + 1):
                value = 0.0
                for q in range(rank):
                    value += loads[q, i] * loads[q, j]
                if cell_session[i] == cell_session[j]:
                    value += session[draw]
                if cell_condition[i] == cell_condition[j]:
                    value += condition[draw]
                if i == j:
                    value += 1.0 / weight[i]
                for m in range(j):
                    value -= lower[i, m] * lower[j, m]
                if i == j:
                    lower[i, i] = np.sqrt(value) if value > 0 else np.nan
                else:
                    lower[i, j] = value / lower[j, j]
            value = mean[i]
            for m in range(i):
                value -= lower[i, m] * y[m]
            y[i] = value / lower[i, i]
            total += y[i] ** 2 + 2 * np.log(lower[i, i])
        result[draw] = -0.5 * total if np.isfinite(total) else -np.inf
    return result
