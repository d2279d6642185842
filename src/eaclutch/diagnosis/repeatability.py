"""How well a run repeats: variance inside (condition, session), the ruler that every gap is measured with."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.records import FloatArray, RunConditions
from eaclutch.rig.table import PRELOAD_EDGES

SESSION_DOF = 2.0  # what the pooled repeat variance weighs against a session's own
BIN = re.compile(r"_p([\d.e+-]+(?:inf)?N|unknown)$")  # the preload bin that a condition's name ends in


@dataclass(frozen=True)
class RepeatVariance:
    """Pooled variance of one observable within (condition, session).

    variance: in the square of the values' unit, not-a-number without degrees of freedom; dof.
    """

    variance: float
    dof: int


def preload_bins(conditions: Sequence[str], preload: FloatArray) -> np.ndarray:
    """Labels (runs,) of the bins inside which one slope against preload is removed: the bins that the conditions are
    named by, or those of ``preload`` [N] (runs,) where a name says none."""
    edges = np.digitize(preload, PRELOAD_EDGES)
    named = [
        found[1] if (found := BIN.search(name)) else str(edge)
        for name, edge in zip(conditions, edges, strict=True)
    ]
    return np.unique(np.array(named, dtype=str), return_inverse=True)[1]


def pooled_variance(
    values: FloatArray, friction_before: FloatArray, groups: FloatArray, bins: FloatArray
) -> RepeatVariance:
    """Variance within groups after regression on the friction before the voltage, one slope a preload bin.

    values, friction_before (runs,); groups, bins (runs,) integer labels. Runs that are not-a-number in
    ``values`` do not count. Contract: "Repeat variance".
    """
    use = np.isfinite(values)
    values, before = values[use], np.nan_to_num(friction_before[use])
    groups, bins = groups[use], bins[use]
    within_values, within_before = centred(values, groups), centred(before, groups)
    dof = len(values) - len(np.unique(groups))
    residual = within_values.copy()
    for label in np.unique(bins):
        rows = bins == label
        spread = float(within_before[rows] @ within_before[rows])
        # a slope needs repeats whose preload really differs
        if spread > 1e-12 and dof > 3 and np.count_nonzero(rows) > 4:
            slope = float(within_before[rows] @ within_values[rows]) / spread
            residual[rows] -= slope * within_before[rows]
            dof -= 1
    variance = float(residual @ residual) / dof if dof > 0 else np.nan
    return RepeatVariance(variance, max(dof, 0))


def shrunk_variance(repeat: RepeatVariance, prior_variance: float, prior_dof: float) -> float:
    """Repeat variance drawn towards what is expected a priori, the more so the fewer the repeats."""
    if repeat.dof == 0:
        return prior_variance
    return (repeat.dof * repeat.variance + prior_dof * prior_variance) / (repeat.dof + prior_dof)


def centred(values: FloatArray, groups: FloatArray) -> FloatArray:
    """Values less the mean of their group, same shape."""
    _, index = np.unique(groups, return_inverse=True)
    count = np.bincount(index)
    return values - (np.bincount(index, weights=values) / count)[index]


def run_variance(
    repeat: RepeatVariance, sd: FloatArray, usable: np.ndarray, thresholds: Mapping[str, Any], block: str
) -> FloatArray:
    """Variance of a single run (runs,): each run's own extractor variance plus what repeats scatter beyond it."""
    own = sd**2
    typical = float(np.median(own[usable]))
    prior = typical + thresholds["repeat_sd"].get(block, 0.02) ** 2
    total = shrunk_variance(repeat, prior, thresholds["repeat_prior_dof"])
    return np.maximum(total - typical, 0.1 * total) + own


def session_share(
    spread: FloatArray,
    pooled: RepeatVariance,
    conditions: RunConditions,
    groups: np.ndarray,
    bins: np.ndarray,
) -> FloatArray:
    """Each run's session's variance over the pooled one, (runs,): what shakes a bench on one day, a line of mains or
    a pump, leaves it alone on the next. Drawn to the pooled one where a session has few repeats, and never below it: a
    few repeats that happen to agree are no quiet day."""
    share = np.ones(len(conditions))
    if pooled.dof == 0 or not pooled.variance > 0:
        return share
    sessions = np.array(conditions.session, dtype=object)
    for name in dict.fromkeys(conditions.session):
        rows = sessions == name
        own = pooled_variance(np.where(rows, spread, np.nan), conditions.friction_before, groups, bins)
        share[rows] = max(1.0, shrunk_variance(own, pooled.variance, SESSION_DOF) / pooled.variance)
    return share
