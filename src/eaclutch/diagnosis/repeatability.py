"""How well a run repeats: variance inside (condition, session), the ruler that every gap is measured with."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.records import FloatArray, RunConditions
from eaclutch.rig.table import PRELOAD_EDGES

FEW = 5  # degrees of freedom below which repeats may agree by chance
EFFICIENCY = 0.37  # of a median as an estimate of normal scatter: what its degrees of freedom are worth
NORMAL = 1.4826  # normal sds in a median absolute deviation
ODD, FITS = 5.0, 4  # sds from which a run takes no part in the next fit, and how many are made
SESSION_DOF = 2.0  # what the pooled repeat variance weighs against a session's own
BIN = re.compile(r"_p([\d.e+-]+(?:inf)?N|unknown)$")  # the preload bin that a condition's name ends in


@dataclass(frozen=True)
class RepeatVariance:
    """Pooled variance of one observable within (condition, session).

    variance: in the square of the values' unit, not-a-number without degrees of freedom; dof.
    """

    variance: float
    dof: int


NOTHING = RepeatVariance(float("nan"), 0)


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


def across_sessions(values: FloatArray, conditions: RunConditions) -> RepeatVariance:
    """Variance of a single run as far as sessions show it: what is left of (condition, session) means once every
    condition and every session has its own. An effect that is the same in all sessions takes no part, nor a session
    that is higher by the same for all conditions; by the median and without the farthest, so that few odd runs do not.

    values (runs,): not-a-number does not count. dof: what the median's are worth, 0 (variance not-a-number) where
    fewer than FEW are left.
    """
    names = np.array(conditions.condition, dtype=str)
    sessions = np.array(conditions.session, dtype=str)
    use = np.isfinite(values)
    once = [name for name in np.unique(names[use]) if len(set(sessions[use & (names == name)])) < 2]
    use &= ~np.isin(names, once)
    _, group = np.unique(np.char.add(np.char.add(names, "|"), sessions)[use], return_inverse=True)
    if len(group) == 0:
        return NOTHING
    count = np.bincount(group)
    mean = np.bincount(group, weights=values[use]) / count
    first = np.flatnonzero(use)[np.unique(group, return_index=True)[1]]
    design = np.hstack([labels[first][:, None] == np.unique(labels[first]) for labels in (names, sessions)])
    kept, variance, dof = np.ones(len(mean), dtype=bool), np.nan, 0
    for _ in range(FITS):
        fit, _, rank, _ = np.linalg.lstsq(design[kept].astype(float), mean[kept], rcond=None)
        dof = int(np.count_nonzero(kept)) - int(rank)
        if dof < FEW:
            return NOTHING
        apart = np.abs(mean - design @ fit) * np.sqrt(count)
        variance = (NORMAL * float(np.median(apart[kept]))) ** 2 * np.count_nonzero(kept) / dof
        # one odd run pulls the mean of its session, and so all others of it, away
        kept = apart <= ODD * np.sqrt(variance)
    return RepeatVariance(variance, int(EFFICIENCY * dof))


def instead(
    repeat: RepeatVariance, compared: Sequence[FloatArray], conditions: RunConditions
) -> RepeatVariance:
    """What shows how runs scatter where repeats are few: the least of what each of ``compared`` (runs,) says across
    sessions; NOTHING where there are enough."""
    if repeat.dof >= FEW:
        return NOTHING
    return min((across_sessions(values, conditions) for values in compared), key=lambda seen: seen.variance)


def shrunk_variance(
    repeat: RepeatVariance, prior_variance: float, prior_dof: float, across: RepeatVariance = NOTHING
) -> float:
    """Variance of repeats, and of runs ``across`` sessions, drawn towards what is expected a priori, the more so the
    fewer there are."""
    seen = [each for each in (repeat, across) if each.dof > 0]
    if not seen:
        return prior_variance
    total = prior_dof * prior_variance + sum(each.dof * each.variance for each in seen)
    return total / (prior_dof + sum(each.dof for each in seen))


def centred(values: FloatArray, groups: FloatArray) -> FloatArray:
    """Values less the mean of their group, same shape."""
    _, index = np.unique(groups, return_inverse=True)
    count = np.bincount(index)
    return values - (np.bincount(index, weights=values) / count)[index]


def run_variance(
    repeat: RepeatVariance,
    across: RepeatVariance,
    sd: FloatArray,
    usable: np.ndarray,
    thresholds: Mapping[str, Any],
    block: str,
) -> FloatArray:
    """Variance of a single run (runs,): each run's own extractor variance plus what repeats scatter beyond it, or runs
    ``across`` sessions (``instead``)."""
    own = sd**2
    typical = float(np.median(own[usable]))
    prior = typical + thresholds["repeat_sd"].get(block, 0.02) ** 2
    total = shrunk_variance(repeat, prior, thresholds["repeat_prior_dof"], across)
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
