"""How well a run repeats: variance inside (condition, session), the ruler that every gap is measured with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eaclutch.records import FloatArray

PRELOAD_EDGES = (0.25, 0.75, 1.5)  # N; bins inside which one slope against preload is removed


@dataclass(frozen=True)
class RepeatVariance:
    """Pooled variance of one observable within (condition, session).

    variance: in the square of the values' unit, not-a-number without degrees of freedom; dof.
    """

    variance: float
    dof: int


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
