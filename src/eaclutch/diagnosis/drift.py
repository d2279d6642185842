"""Whether repeats drift with the run order within a session: what drifts would pass for scatter of repeats.

A gap is measured with what repeats of a condition in a session scatter by. A bench that warms up or wears between them
makes that ruler long, and everything seems to lie within it; but scatter has no order, and a drift has. How clear an
order is, is told by changing the places of repeats (they could have come in any order), for scatter has far tails.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.repeatability import centred, preload_bins
from eaclutch.records import FloatArray

FEWEST = 8  # degrees of freedom of the repeats' scatter, from which an order is looked for
# of repeats, drawn at random at a time; so often, until ENOUGH say as much as the one measured
ORDERS, BATCHES = 10_000, 100
PLACES = 2_000_000  # of all orders drawn at a time: what fits into memory however many runs there are
ENOUGH = 10
SMALL = 1e-300  # a sum of squares that is none


@dataclass(frozen=True)
class RepeatDrift:
    """The channel whose repeats follow the run order most clearly.

    share: of the scatter of repeats that straight lines against the order say, one a session; p_value: the chance that
    an order drawn at random says as much, times the number of channels; evidence [nats]: the most that this p-value can
    stand for, -log(-e p log p) (Sellke, Bayarri & Berger, The American Statistician 55
    (2001) 62, doi:10.1198/000313001300339950); size: the root mean square over all runs of what the lines move, on the
    comparison scale.
    """

    channel: str
    share: float
    p_value: float
    evidence: float
    size: float


@dataclass(frozen=True)
class _Repeats:
    """A channel's scatter (runs,) within groups, what follows the preload taken off, and an orthonormal basis (runs,
    lines) of what lines against the order could say of it; size: of the best lines over all runs."""

    channel: str
    block: str
    scatter: FloatArray
    groups: np.ndarray
    basis: FloatArray
    size: float

    @property
    def orders(self) -> int:
        """How many are drawn at a time."""
        return max(1, min(ORDERS, PLACES // len(self.scatter)))

    def share(self, scatter: FloatArray) -> FloatArray:
        """Of ``scatter`` (..., runs), what the lines say."""
        said: FloatArray = np.sum((scatter @ self.basis) ** 2, axis=-1) / max(
            float(self.scatter @ self.scatter), SMALL
        )
        return said

    def reordered(self, rng: np.random.Generator) -> FloatArray:
        """(``orders``,) shares with the repeats of each group in another order, drawn at random."""
        place = np.argsort(self.groups, kind="stable")
        keys = self.groups[place] + rng.random((self.orders, len(place)))
        drawn = np.empty((self.orders, len(place)))
        drawn[:, place] = self.scatter[place][np.argsort(keys, axis=1)]
        return self.share(drawn)

    def chance(self, rng: np.random.Generator) -> float:
        """That an order drawn at random says as much as the measured one (Besag & Clifford, Biometrika 78 (1991) 301,
        doi:10.1093/biomet/78.2.301: drawn until it is known well enough)."""
        seen, as_much, batches = (1.0 - 1e-9) * float(self.share(self.scatter)), 0, 0
        while as_much < ENOUGH and batches < BATCHES:
            as_much += int(np.sum(self.reordered(rng) >= seen))
            batches += 1
        return (as_much + 1.0) / (batches * self.orders + 1.0)


def repeat_drift(
    data: DataVector, thresholds: Mapping[str, Any], rng: np.random.Generator
) -> RepeatDrift | None:
    """The clearest drift of repeats that is larger than sessions may differ by (``repeat_drift`` times ``session_sd``),
    or None without a clear one."""
    bins = preload_bins(data.conditions.condition, data.preload)
    found = [_repeats(data, i, bins) for i in range(len(data.channels))]
    tested = [repeats for repeats in found if repeats is not None]
    large = [r for r in tested if r.size > thresholds["repeat_drift"] * thresholds["session_sd"][r.block]]
    if not large:
        return None
    chances = [r.chance(rng) for r in large]
    p_value = len(tested) * min(chances)
    if p_value > thresholds["caveats"]["order_p_value"]:
        return None
    repeats = large[int(np.argmin(chances))]
    evidence = float(-np.log(-np.e * p_value * np.log(p_value)))
    return RepeatDrift(
        repeats.channel, float(repeats.share(repeats.scatter)), p_value, evidence, repeats.size
    )


def _repeats(data: DataVector, index: int, bins: np.ndarray) -> _Repeats | None:
    """One channel's repeats; None where they are too few, or none at another place in the order."""
    values, conditions = data.run_values[index], data.conditions
    use = np.isfinite(values)
    groups = np.unique(data.groups[use], return_inverse=True)[1]
    if len(groups) == 0 or len(groups) == groups.max() + 1:
        return None
    order = np.asarray(conditions.run_order, dtype=float)[use]
    sessions = np.array(conditions.session, dtype=str)[use]
    before = _by_level(centred(np.nan_to_num(conditions.friction_before[use]), groups), bins[use])
    known = _basis(before)
    lines = _by_level(centred(order, groups), sessions)
    lines = lines - known @ (known.T @ lines)
    basis = _basis(lines)
    scatter = centred(values[use], groups)
    scatter = scatter - known @ (known.T @ scatter)
    free = len(scatter) - (groups.max() + 1) - known.shape[1] - basis.shape[1]
    if basis.shape[1] == 0 or free < FEWEST:
        return None
    slopes = np.linalg.lstsq(lines, scatter, rcond=None)[0]
    moved = _by_level(centred(order, sessions), sessions) @ slopes
    channel = data.channels[index]
    return _Repeats(channel.name, channel.block, scatter, groups, basis, float(np.sqrt(np.mean(moved**2))))


def _by_level(values: FloatArray, levels: np.ndarray) -> FloatArray:
    """(runs, levels): ``values`` (runs,) in the column of each run's level, zero elsewhere."""
    columns: FloatArray = values[:, None] * (levels[:, None] == np.unique(levels)[None, :])
    return columns


def _basis(columns: FloatArray) -> FloatArray:
    """Orthonormal columns that span those given."""
    left, size, _ = np.linalg.svd(columns, full_matrices=False)
    return left[:, size > 1e-9 * max(float(size.max(initial=0.0)), SMALL)]
