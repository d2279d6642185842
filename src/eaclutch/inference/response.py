"""The model's capacity tabulated over the force multiplier for every joint draw of the other parameters.

The multiplier enters the model as a factor on the force, so the whole dependence on it is one curve a (draw, run).
The spread of these curves over the draws is reduced to its leading principal components; their scores z are
uncorrelated with unit variance over the draws and are treated as Gaussian.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numba
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import ndtr, ndtri

from eaclutch.inference.problem import digest
from eaclutch.records import FloatArray

LOG_GRID = np.linspace(np.log(0.05), np.log(20.0), 41)
VARIANCE_KEPT = 1 - 1e-4
MOST_FACTORS = 8
SHORT_OF_THE_END = 1e-9  # of a span: an end itself has no normal score

Capacity = Callable[[Mapping[str, FloatArray], float], FloatArray]
"""(nuisance draws, multiplier) -> capacity (draws, runs) [N], NaN where the model has none."""


@dataclass(frozen=True)
class Scales:
    """On which scale parameters move, each (params,): low, high: ends of those that lie between two (else NaN), by the
    normal score of where they lie; logarithmic: those that are positive; the others as they are."""

    low: FloatArray
    high: FloatArray
    logarithmic: np.ndarray

    @classmethod
    def of(cls, names: Sequence[str], values: FloatArray, spans: Mapping[str, tuple[float, float]]) -> Scales:
        ends = np.array([spans.get(name, (np.nan, np.nan)) for name in names]).reshape(-1, 2)
        return cls(ends[:, 0], ends[:, 1], np.all(values > 0, axis=0) & np.isnan(ends[:, 0]))

    def forward(self, values: FloatArray) -> FloatArray:
        """To the scale, (draws, params)."""
        share = np.clip((values - self.low) / (self.high - self.low), SHORT_OF_THE_END, 1 - SHORT_OF_THE_END)
        plain = np.where(self.logarithmic, np.log(np.where(self.logarithmic, values, 1.0)), values)
        return np.where(np.isnan(self.low), plain, ndtri(share))

    def back(self, scaled: FloatArray) -> FloatArray:
        """Inverse of ``forward``."""
        plain = np.where(self.logarithmic, np.exp(np.where(self.logarithmic, scaled, 0.0)), scaled)
        return np.where(np.isnan(self.low), plain, self.low + (self.high - self.low) * ndtr(scaled))


@dataclass(frozen=True)
class Response:
    """mean and factors as cubic pieces over ln lambda, log_share: log share of draws that have a capacity;
    z (draws, rank): scores; values (draws, params) and loadings (params, rank): nuisances and how they follow z, on the
    scale on which they move (``Scales``)."""

    mean: FloatArray  # (runs, pieces, 4), highest power first
    factors: FloatArray  # (runs, pieces, rank, 4)
    log_share: FloatArray  # (grid, runs)
    z: FloatArray
    names: tuple[str, ...]
    values: FloatArray
    loadings: FloatArray
    scales: Scales
    units: Mapping[str, str]
    fingerprint: str

    @property
    def draws(self) -> int:
        return len(self.z)

    @property
    def rank(self) -> int:
        return self.z.shape[1]

    @classmethod
    def tabulate(
        cls,
        capacity: Capacity,
        nuisances: Mapping[str, FloatArray],
        units: Mapping[str, str],
        spans: Mapping[str, tuple[float, float]] = MappingProxyType({}),
    ) -> Response:
        """Evaluate ``capacity`` on the grid for all draws of ``nuisances`` {name: (draws,)}; spans {name: (low, high)}:
        of those that can be anything between two ends, and nothing else."""
        table = np.stack([np.log(capacity(nuisances, float(np.exp(x)))) for x in LOG_GRID], axis=2)
        finite = np.isfinite(table)  # (draws, runs, grid)
        count = finite.sum(axis=0)
        mean = np.where(finite, table, 0.0).sum(axis=0) / np.maximum(count, 1)
        mean = _filled(np.where(count > 0, mean, np.nan))
        deviation = np.where(finite, table - mean, 0.0)
        draws = len(deviation)
        near = np.abs(LOG_GRID) < np.log(4.0)  # the factors shall describe where lambda can be
        u, s, _ = np.linalg.svd(deviation[:, :, near].reshape(draws, -1), full_matrices=False)
        share = np.cumsum(s**2) / max(np.sum(s**2), 1e-300)
        rank = min(int(np.searchsorted(share, VARIANCE_KEPT)) + 1, MOST_FACTORS, draws)
        z = u[:, :rank] * np.sqrt(draws)
        loads = np.einsum("dq,drg->qrg", z, deviation) / draws
        with np.errstate(divide="ignore"):
            log_share = np.log(count / draws).T
        names = tuple(nuisances)
        values = np.stack([nuisances[name] for name in names], axis=1) if names else np.zeros((draws, 0))
        scales = Scales.of(names, values, spans)
        scaled = scales.forward(values)
        loadings = (scaled - scaled.mean(axis=0)).T @ z / draws
        mean_pieces = np.ascontiguousarray(np.transpose(CubicSpline(LOG_GRID, mean, axis=1).c, (2, 1, 0)))
        pieces = CubicSpline(LOG_GRID, loads, axis=2).c  # (4, pieces, rank, runs)
        return cls(
            mean_pieces, np.ascontiguousarray(np.transpose(pieces, (3, 1, 2, 0))), log_share, z, names, values,
            loadings, scales, dict(units), digest(table),
        )  # fmt: skip

    def at(self, multiplier: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mean (draws, runs), factors (draws, rank, runs) and log share (draws, runs) at multipliers (draws, runs).

        Beyond the grid, or where the multiplier is not positive, the share is zero.
        """
        return _evaluate(
            np.ascontiguousarray(multiplier),
            self.mean,
            self.factors,
            self.log_share,
            LOG_GRID[0],
            LOG_GRID[-1],
        )

    def select(self, rows: np.ndarray) -> Response:
        """The response of some runs."""
        return replace(
            self,
            mean=self.mean[rows],
            factors=self.factors[rows],
            log_share=np.ascontiguousarray(self.log_share[:, rows]),
        )

    def nuisances(self, which: np.ndarray, moved: FloatArray) -> dict[str, FloatArray]:
        """Nuisance draws ``which`` (n,) with their scores moved to ``moved`` (n, rank)."""
        shift = (moved - self.z[which]) @ self.loadings.T
        new = self.scales.back(self.scales.forward(self.values[which]) + shift)
        return {name: new[:, i] for i, name in enumerate(self.names)}


@numba.njit(cache=True, nogil=True)
def _evaluate(multiplier, mean, factors, log_share, low, high):  # type: ignore[no-untyped-def]
    draws, runs = multiplier.shape
    pieces, rank = factors.shape[1], factors.shape[2]
    step = (high - low) / pieces
    value, loads = np.zeros((draws, runs)), np.zeros((draws, rank, runs))
    share = np.full((draws, runs), -np.inf)
    for draw in range(draws):
        for run in range(runs):
            if not multiplier[draw, run] > 0.0:
                continue
            x = np.log(multiplier[draw, run])
            if x < low or x > high:
                continue
            piece = min(int((x - low) / step), pieces - 1)
            offset = x - (low + piece * step)
            c = mean[run, piece]
            value[draw, run] = ((c[0] * offset + c[1]) * offset + c[2]) * offset + c[3]
            for q in range(rank):
                c = factors[run, piece, q]
                loads[draw, q, run] = ((c[0] * offset + c[1]) * offset + c[2]) * offset + c[3]
            share[draw, run] = log_share[min(piece + (1 if offset > 0.5 * step else 0), pieces), run]
    return value, loads, share


def _filled(mean: FloatArray) -> FloatArray:
    """(runs, grid) with gaps (no draw has a capacity) continued from the nearest grid value; their share is zero."""
    result = mean.copy()
    grid = np.arange(mean.shape[1])
    for row in result:
        known = np.isfinite(row)
        row[:] = np.interp(grid, grid[known], row[known]) if known.any() else 0.0
    return result
