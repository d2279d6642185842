"""How well a run repeats: variance inside (condition, session), the ruler that every gap is measured with."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from eaclutch.records import FloatArray, RunConditions
from eaclutch.rig.table import PRELOAD_EDGES

LEAST_SCATTER = 1e-3  # of the plain variance: repeats that agree better than each is known
LEAST_SHARE = 0.1  # of a run's variance, that its repeats scatter by beyond what it is known by
SESSION_DOF = 2.0  # what the pooled repeat variance weighs against a session's own
BIN = re.compile(r"_p([\d.e+-]+(?:inf)?N|unknown)$")  # the preload bin that a condition's name ends in


@dataclass(frozen=True)
class RepeatVariance:
    """Pooled variance of one observable within (condition, session).

    variance: of a run whose own uncertainty is the usual one, in the square of the values' unit, not-a-number without
    degrees of freedom; dof. own: how much of it is that uncertainty, as far as it was told.
    """

    variance: float
    dof: int
    own: float = 0.0

    @property
    def beyond(self) -> float:
        """What repeats scatter by beyond what each of them is known by."""
        return self.variance - self.own


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
    values: FloatArray,
    friction_before: FloatArray,
    groups: FloatArray,
    bins: FloatArray,
    own: FloatArray | None = None,
) -> RepeatVariance:
    """Variance within groups after regression on the friction before the voltage, one slope a preload bin.

    values, friction_before (runs,); groups, bins (runs,) integer labels. Runs that are not-a-number in
    ``values`` do not count. Contract: "Repeat variance". With ``own`` (runs,), the variance that each run has by
    itself, runs weigh as they are known, lest one that is hardly known stretch the ruler for all: what they scatter
    beyond it is such that their weighed squares are as large as their degrees of freedom (Paule & Mandel 1982,
    doi:10.6028/jres.087.022), and the variance is that of a run whose own is the median. Runs whose own is not finite
    do not count, either.
    """
    use = np.isfinite(values) & (True if own is None else np.isfinite(own))
    rows = _Rows(values[use], np.nan_to_num(friction_before[use]), groups[use], bins[use])
    if rows.dof <= 0:
        return RepeatVariance(np.nan, 0)
    plain = rows.squares(np.ones(len(rows.values))) / rows.dof
    if own is None or not plain > 0.0:
        return RepeatVariance(plain, rows.dof)
    alone = own[use]

    def beyond(scatter: float) -> float:
        return rows.squares(1.0 / (alone + scatter)) - rows.dof

    scatter = LEAST_SCATTER * plain
    if beyond(plain) >= 0.0:  # rounding, where none has an own
        scatter = plain
    elif beyond(scatter) > 0.0:
        scatter = float(brentq(beyond, scatter, plain, xtol=1e-6 * plain))
    usual = float(np.median(alone))
    return RepeatVariance(scatter + usual, rows.dof, usual)


class _Rows:
    """The runs that count, each array (runs,), and the degrees of freedom of their scatter within groups."""

    def __init__(self, values: FloatArray, before: FloatArray, groups: FloatArray, bins: FloatArray) -> None:
        self.values, self.before, self.groups = values, before, groups
        self.dof, self.slopes = len(values) - len(np.unique(groups)), []
        within = centred(before, groups)
        for label in np.unique(bins):
            rows = bins == label
            # a slope needs repeats whose preload really differs
            if float(within[rows] @ within[rows]) > 1e-12 and self.dof > 3 and np.count_nonzero(rows) > 4:
                self.slopes.append(rows)
                self.dof -= 1
        self.dof = max(self.dof, 0)

    def squares(self, weights: FloatArray) -> float:
        """Weighed sum of squares within groups, slopes taken off, for ``weights`` (runs,)."""
        residual, before = (centred(x, self.groups, weights) for x in (self.values, self.before))
        for rows in self.slopes:
            weighed = weights[rows] * before[rows]
            residual[rows] -= float(weighed @ residual[rows]) / float(weighed @ before[rows]) * before[rows]
        return float(weights @ residual**2)


def shrunk_variance(repeat: RepeatVariance, prior_variance: float, prior_dof: float) -> float:
    """Repeat variance drawn towards what is expected a priori, the more so the fewer the repeats."""
    if repeat.dof == 0:
        return prior_variance
    return _drawn(repeat.variance, repeat.dof, prior_variance, prior_dof)


def centred(values: FloatArray, groups: FloatArray, weights: FloatArray | None = None) -> FloatArray:
    """Values less the (weighed) mean of their group, same shape."""
    _, index = np.unique(groups, return_inverse=True)
    weights = np.ones(len(values)) if weights is None else weights
    mean = np.bincount(index, weights=weights * values) / np.bincount(index, weights=weights)
    found: FloatArray = values - mean[index]
    return found


def usual_scatter(
    repeat: RepeatVariance, sd: FloatArray, usable: np.ndarray, thresholds: Mapping[str, Any], block: str
) -> float:
    """What runs scatter by beyond what each is known by (``sd``, (runs,)), drawn to what is expected where repeats are
    few."""
    typical = float(np.median(sd[usable] ** 2))
    prior = typical + thresholds["repeat_sd"].get(block, 0.02) ** 2
    total = shrunk_variance(repeat, prior, thresholds["repeat_prior_dof"])
    return max(total - typical, LEAST_SHARE * total)


def scatter_by_session(
    usual: float,
    pooled: RepeatVariance,
    spread: FloatArray,
    conditions: RunConditions,
    groups: np.ndarray,
    bins: np.ndarray,
    own: FloatArray,
) -> FloatArray:
    """The scatter of each run's session (runs,), where ``pooled`` of all comes to ``usual`` and each run has its
    ``own`` besides: what shakes a bench on one day, a line of mains or a pump, leaves it alone on the next. Drawn to
    the usual one where a session has few repeats, and never below it: a few repeats that happen to agree are no quiet
    day."""
    found = np.full(len(conditions), usual)
    sessions = np.array(conditions.session, dtype=object)
    ruler = max(pooled.beyond, LEAST_SHARE * pooled.variance)
    if pooled.dof == 0 or not ruler > 0.0:
        return found
    for name in dict.fromkeys(conditions.session):
        rows = sessions == name
        there = pooled_variance(np.where(rows, spread, np.nan), conditions.friction_before, groups, bins, own)
        drawn = ruler if there.dof == 0 else _drawn(there.beyond, there.dof, ruler, SESSION_DOF)
        found[rows] = usual * max(1.0, drawn / ruler)
    return found


def _drawn(variance: float, dof: float, expected: float, weight: float) -> float:
    """A variance of ``dof`` degrees of freedom drawn to what is expected, which weighs as ``weight`` of them."""
    return (dof * variance + weight * expected) / (dof + weight)
