"""Whether repeats drift with the run order within a session: what drifts would pass for scatter of repeats.

A gap is measured with what repeats of a condition in a session scatter by. A bench that warms up or wears between them
makes that ruler long, and everything seems to lie within it; but scatter has no order, and a drift has.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import f as fisher

from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.repeatability import centred, preload_bins
from eaclutch.records import FloatArray

FEWEST = 8  # degrees of freedom of the repeats' scatter, from which an order is looked for


@dataclass(frozen=True)
class RepeatDrift:
    """The channel whose repeats follow the run order most clearly.

    share: of the scatter of repeats that straight lines against the order say, one a session; p_value: that of their F
    test, times the number of channels; evidence [nats]: of the lines, by the Bayesian information criterion, less what
    the choice among channels costs; size: the root mean square over all runs of what the lines move, on the comparison
    scale.
    """

    channel: str
    share: float
    p_value: float
    evidence: float
    size: float


def repeat_drift(data: DataVector, preload: FloatArray, thresholds: Mapping[str, Any]) -> RepeatDrift | None:
    """The clearest drift of repeats that is larger than sessions may differ by (``repeat_drift`` times ``session_sd``),
    or None without one. preload (runs,) [N]: bins the runs whose conditions name no preload."""
    bins = preload_bins(data.conditions.condition, preload)
    found = [_drift(data, i, bins) for i in range(len(data.channels))]
    tested = [drift for drift in found if drift is not None]
    blocks = {channel.name: channel.block for channel in data.channels}
    large = [
        drift
        for drift in tested
        if drift.size > thresholds["repeat_drift"] * thresholds["session_sd"][blocks[drift.channel]]
    ]
    best = max(large, key=lambda drift: drift.evidence, default=None)
    if best is None:
        return None
    p_value, evidence = min(1.0, len(tested) * best.p_value), best.evidence - float(np.log(len(tested)))
    return RepeatDrift(best.channel, best.share, p_value, evidence, best.size) if evidence > 0.0 else None


def _drift(data: DataVector, index: int, bins: np.ndarray) -> RepeatDrift | None:
    """One channel's drift; None where it has too few repeats, or none at another place in the order."""
    values = data.run_values[index]
    use = np.isfinite(values)
    groups, conditions = data.groups[use], data.conditions
    if len(groups) == len(set(groups.tolist())):
        return None
    order = np.asarray(conditions.run_order, dtype=float)[use]
    sessions = np.array(conditions.session, dtype=str)[use]
    scatter = centred(values[use], groups)
    before = _by_level(centred(np.nan_to_num(conditions.friction_before[use]), groups), bins[use])
    lines = _by_level(centred(order, groups), sessions)
    plain, known, _ = _fit(before, scatter)
    drifting, both, slopes = _fit(np.hstack([before, lines]), scatter)
    free = len(scatter) - len(set(groups.tolist())) - known
    count = both - known
    if count == 0 or free - count < FEWEST or not 0.0 < drifting < plain:
        return None
    ratio = (plain - drifting) / count / (drifting / (free - count))
    moved = _by_level(centred(order, sessions), sessions) @ slopes[before.shape[1] :]
    return RepeatDrift(
        data.channels[index].name,
        1.0 - drifting / plain,
        float(fisher.sf(ratio, count, free - count)),
        0.5 * free * float(np.log(plain / drifting)) - 0.5 * count * float(np.log(free)),
        float(np.sqrt(np.mean(moved**2))),
    )


def _by_level(values: FloatArray, levels: np.ndarray) -> FloatArray:
    """(runs, levels): ``values`` (runs,) in the column of each run's level, zero elsewhere."""
    columns: FloatArray = values[:, None] * (levels[:, None] == np.unique(levels)[None, :])
    return columns


def _fit(design: FloatArray, values: FloatArray) -> tuple[float, int, FloatArray]:
    """(sum of squares left, rank, coefficients) by least squares; a column of zeros has the coefficient 0."""
    coefficients, _, rank, _ = np.linalg.lstsq(design, values, rcond=None)
    left = values - design @ coefficients
    return float(left @ left), int(rank), coefficients
