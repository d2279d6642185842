"""The gate: is there a gap beyond what repeats, sessions and the base laws' own tolerance explain?

The reference is a set of campaigns simulated from a fitted model with between-session spread; every p-value of a table
comes from one set, so that one family-wise error rate holds for all of it (maximum statistic, Westfall & Young 1993).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eaclutch.diagnosis.gaussian import LeaveOut, Linearised
from eaclutch.records import FloatArray


@dataclass(frozen=True)
class NullSet:
    """Simulated data vectors of a model that is right: ``w`` (campaigns, entries) with the tolerance in,
    ``strict`` (campaigns, entries) with noise and session spread only."""

    w: FloatArray
    strict: FloatArray


def simulate_null(
    fit: Linearised, strict_covariance: FloatArray, rng: np.random.Generator, campaigns: int = 400
) -> NullSet:
    """Draw data vectors of the fitted model: parameters from their posterior, fresh noise and tolerance.

    From the posterior and not the prior: a parameter that the campaign pins down far from where its prior
    expected it (a force zero) must not blow up the floor of every left-out prediction.
    """
    size, count = fit.jacobian.shape
    gain = np.linalg.solve(fit.marginal(), fit.jacobian)
    posterior = np.eye(count) - fit.jacobian.T @ gain
    values, vectors = np.linalg.eigh(0.5 * (posterior + posterior.T))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    draws = gain.T @ fit.w + rng.standard_normal((campaigns, count)) @ root.T
    shift = draws @ fit.jacobian.T
    tolerant_root = np.linalg.cholesky(fit.covariance)
    strict_root = np.linalg.cholesky(strict_covariance)
    white = rng.standard_normal((campaigns, size))
    return NullSet(white @ tolerant_root.T + shift, white @ strict_root.T + shift)


def adequacy(
    fit: Linearised, left_out: LeaveOut, blocks: np.ndarray, null: NullSet
) -> tuple[float, dict[str, float]]:
    """p-value of the largest block misfit, and each block's (adjusted for all of them).

    A block's misfit is the mean square of its left-out residuals, each over its own standard deviation.
    """
    sd = np.sqrt(np.maximum(np.var(null.w @ left_out.conditional.T, axis=0), 1e-30))
    names = [name for name in dict.fromkeys(blocks.tolist()) if name]
    use = [np.flatnonzero(blocks == name) for name in names]
    measured = _block_misfit(fit.w @ left_out.conditional.T / sd, use)
    simulated = _block_misfit(null.w @ left_out.conditional.T / sd, use)
    adjusted = max_statistic(measured, simulated)
    return float(np.min(adjusted)), dict(zip(names, adjusted.tolist(), strict=True))


def _block_misfit(standardised: FloatArray, blocks: list[np.ndarray]) -> FloatArray:
    return np.stack([np.mean(standardised[..., rows] ** 2, axis=-1) for rows in blocks], axis=-1)


def max_statistic(measured: FloatArray, simulated: FloatArray) -> FloatArray:
    """Family-wise adjusted p-values (tests,) of statistics whose null is ``simulated`` (campaigns, tests).

    Each statistic is centred and scaled by its own null first, so that tests of different spread count alike;
    the smallest possible p is 1 / (campaigns + 1).
    """
    campaigns = len(simulated)
    order = np.sort(simulated, axis=0)
    centre, spread = np.median(order, axis=0), np.std(order, axis=0) + 1e-300
    standard = (simulated - centre) / spread
    largest = np.sort(standard.max(axis=1))
    mine = (measured - centre) / spread
    above = campaigns - np.searchsorted(largest, mine, side="left")
    return (1.0 + above) / (1.0 + campaigns)
