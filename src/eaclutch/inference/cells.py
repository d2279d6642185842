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
    and level sds (draws,).

    The more numerous levels (sessions or conditions) are eliminated one by one, so cost grows with the cells and
    not with their cube.
    """
    levels = (session_sd, cells.cell_session), (condition_sd, cells.cell_condition)
    (many_sd, many), (few_sd, few) = levels if cells.sessions > cells.conditions else levels[::-1]
    return _likelihood(
        np.ascontiguousarray(residual), np.ascontiguousarray(factors), np.ascontiguousarray(variance),
        many_sd, few_sd, cells.cell, many, few,
    )  # fmt: skip


@numba.njit(cache=True, nogil=True)
def _likelihood(residual, factors, variance, many_sd, few_sd, cell, many, few):  # type: ignore[no-untyped-def]
    """K = D + U U', U = [factors, few_sd Z_few, many_sd Z_many] over cells; log |K| and the quadratic form from
    M = I + U' D^-1 U, of which the block of ``many`` is diagonal."""
    draws, runs = residual.shape
    count, rank = len(many), factors.shape[1]
    groups, size = many.max() + 1, factors.shape[1] + few.max() + 1
    result = np.empty(draws)
    weight, mean, loads = np.empty(count), np.empty(count), np.empty((rank, count))
    kept, right, cross = np.empty((size, size)), np.empty(size), np.empty((groups, size))
    alone, alone_right = np.empty(groups), np.empty(groups)
    for draw in range(draws):
        weight[:], mean[:], loads[:], total = 0.0, 0.0, 0.0, 0.0
        for run in range(runs):
            precision, c = 1.0 / variance[draw, run], cell[run]
            weight[c] += precision
            mean[c] += precision * residual[draw, run]
            total += np.log(2 * np.pi * variance[draw, run]) + precision * residual[draw, run] ** 2
            for q in range(rank):
                loads[q, c] += precision * factors[draw, q, run]
        kept[:], right[:], cross[:], alone[:], alone_right[:] = 0.0, 0.0, 0.0, 1.0, 0.0
        one, other = few_sd[draw], many_sd[draw]
        for c in range(count):
            w, at, group = weight[c], rank + few[c], many[c]
            mean[c] /= w
            for q in range(rank):
                loads[q, c] /= w
                for p in range(q + 1):
                    kept[q, p] += w * loads[q, c] * loads[p, c]
                kept[at, q] += w * one * loads[q, c]
                right[q] += w * loads[q, c] * mean[c]
                cross[group, q] += w * other * loads[q, c]
            kept[at, at] += w * one**2
            right[at] += w * one * mean[c]
            cross[group, at] += w * other * one
            alone[group] += w * other**2
            alone_right[group] += w * other * mean[c]
        for group in range(groups):
            total += np.log(alone[group]) - alone_right[group] ** 2 / alone[group]
            for i in range(size):
                if cross[group, i] != 0.0:
                    share = cross[group, i] / alone[group]
                    right[i] -= share * alone_right[group]
                    for j in range(i + 1):
                        kept[i, j] -= share * cross[group, j]
        for i in range(size):  # Cholesky of I + kept, solved on the way
            kept[i, i] += 1.0
            for j in range(i + 1):
                for m in range(j):
                    kept[i, j] -= kept[i, m] * kept[j, m]
                if i == j:
                    kept[i, i] = np.sqrt(kept[i, i]) if kept[i, i] > 0 else np.nan
                else:
                    kept[i, j] /= kept[j, j]
            for m in range(i):
                right[i] -= kept[i, m] * right[m]
            right[i] /= kept[i, i]
            total += 2 * np.log(kept[i, i]) - right[i] ** 2
        result[draw] = -0.5 * total if np.isfinite(total) else -np.inf
    return result
