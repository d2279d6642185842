"""Calibration curves: how often measured values lie in predicted intervals of every nominal level."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.stats import beta

from eaclutch.records import FloatArray

LEVELS = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95])


def ranks(replicated: FloatArray, measured: FloatArray) -> FloatArray:
    """Share of predictions (draws, runs) below the measured value, (runs,); NaN where either is missing.

    A run counts where more than half of its draws have a number.
    """
    finite = np.isfinite(replicated)
    enough = finite.mean(axis=0) > 0.5
    below = np.where(finite, replicated < measured, False).sum(axis=0)
    count = finite.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (below + 0.5) / (count + 1)
    return np.where(enough & np.isfinite(measured), share, np.nan)


def calibration(rank: FloatArray) -> dict[str, Any] | None:
    """Coverage of central intervals at each level from ranks, with the 90 % Clopper-Pearson interval."""
    rank = rank[np.isfinite(rank)]
    n = len(rank)
    if n == 0:
        return None
    inside = np.array([np.sum(np.abs(rank - 0.5) <= level / 2) for level in LEVELS])
    with np.errstate(invalid="ignore"):
        low = np.where(inside > 0, beta.ppf(0.05, inside, n - inside + 1), 0.0)
        high = np.where(inside < n, beta.ppf(0.95, inside + 1, n - inside), 1.0)
    return {"runs": n, "level": LEVELS, "covered": inside / n, "low": low, "high": high}


def coverage_document(by_split: Mapping[str, Mapping[str, FloatArray]]) -> dict[str, Any]:
    """{split: {observable: curve, "all": curve}} from ranks {split: {observable: (runs,)}}."""
    document: dict[str, Any] = {}
    for split, observables in by_split.items():
        curves = {name: calibration(rank) for name, rank in observables.items()}
        pooled = np.concatenate(list(observables.values())) if observables else np.zeros(0)
        document[split] = {"all": calibration(pooled), **{n: c for n, c in curves.items() if c is not None}}
    return document
