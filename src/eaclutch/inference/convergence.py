"""Convergence of ensemble samplers, with the ensemble as the chain.

Walkers of one ensemble move by looking at each other, so they are not independent chains and diagnostics on
interleaved walkers flatter. Here R-hat compares whole ensembles: split R-hat (Gelman et al., Bayesian Data
Analysis, 3rd ed., 11.4) of the per-step mean and 5 / 95 % quantiles over an ensemble's walkers, the largest of
the three. ESS = walkers x steps x ensembles / tau, tau the integrated autocorrelation time of Goodman & Weare
(2010, doi:10.2140/camcos.2010.5.65) as emcee estimates it: of the parameter for the bulk, of the indicators of
the lowest and highest 5 % for the tails (the longer of the two).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from emcee.autocorr import integrated_time

from eaclutch.records import FloatArray


@dataclass(frozen=True)
class Thresholds:
    """What a converged run must reach."""

    r_hat: float = 1.01
    ess: float = 400.0
    lengths: float = 50.0  # steps in autocorrelation times


@dataclass(frozen=True)
class Diagnostics:
    """Arrays (params,); steps: kept steps per ensemble; tau in steps; lengths = steps / longest tau."""

    r_hat: FloatArray
    ess_bulk: FloatArray
    ess_tail: FloatArray
    tau: FloatArray
    steps: int
    lengths: float

    def passed(self, limits: Thresholds) -> bool:
        return not self.failures(limits)

    def failures(self, limits: Thresholds) -> list[str]:
        """Each threshold that is missed, in words; empty when converged."""
        missed = []
        if not np.all(self.r_hat <= limits.r_hat):
            missed.append(f"R-hat {np.nanmax(self.r_hat):.4f} > {limits.r_hat:g}")
        ess = min(np.min(self.ess_bulk), np.min(self.ess_tail))
        if not ess >= limits.ess:
            missed.append(f"ESS {ess:.0f} < {limits.ess:g}")
        if not self.lengths >= limits.lengths:
            missed.append(f"{self.lengths:.0f} autocorrelation times < {limits.lengths:g}")
        return missed


def diagnose(chain: FloatArray) -> Diagnostics:
    """Diagnostics of a chain (ensembles, steps, walkers, params) without its burn-in."""
    ensembles, steps, walkers, params = chain.shape
    summaries = np.stack(
        [chain.mean(axis=2), np.quantile(chain, 0.05, axis=2), np.quantile(chain, 0.95, axis=2)]
    )  # (3, ensembles, steps, params)
    r_hat = np.max([[split_r_hat(s[:, :, p]) for p in range(params)] for s in summaries], axis=0)
    low, high = np.quantile(chain, [0.05, 0.95], axis=(0, 1, 2))
    tau = autocorrelation_time(chain)
    tail = np.maximum(
        autocorrelation_time((chain <= low).astype(float)),
        autocorrelation_time((chain >= high).astype(float)),
    )
    size = ensembles * steps * walkers
    return Diagnostics(r_hat, size / tau, size / tail, tau, steps, float(steps / np.max(tau)))


def split_r_hat(series: FloatArray) -> float:
    """Split R-hat of series (chains, steps)."""
    half = series.shape[1] // 2
    if half < 2:
        return np.inf
    parts = np.concatenate([series[:, :half], series[:, -half:]])
    within = float(np.mean(np.var(parts, axis=1, ddof=1)))
    between = float(np.var(np.mean(parts, axis=1), ddof=1))
    if within == 0:
        return 1.0 if between == 0 else np.inf
    return float(np.sqrt((half - 1) / half + between / within))


def autocorrelation_time(chain: FloatArray) -> FloatArray:
    """Integrated autocorrelation time (params,) in steps, at least 1, of (ensembles, steps, walkers, params).

    emcee averages the autocorrelation function over an ensemble's walkers; the mean over ensembles is taken.
    """
    times = []
    for ensemble in chain:
        with np.errstate(invalid="ignore", divide="ignore"):
            times.append(integrated_time(ensemble, tol=0, quiet=True, has_walkers=True))
    tau = np.mean(times, axis=0)
    return np.maximum(np.where(np.isfinite(tau), tau, 1.0), 1.0)
