"""Stick-slip while driven: how much of the force the largest slip lets go."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import FloatArray, ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView
from eaclutch.rig.zero import UNKNOWN_ZERO_SD

SIDE = 0.0015  # s of mean force on either side of a slip
DURATION = 0.002  # s: a slip lasts about half a period of the load cell (0.8 ms)
THRESHOLD = 7.0  # standard deviations of the difference of two such means
CLEAR = 0.001  # s kept clear of voltage on and off


def slips(force: FloatArray, step: float) -> tuple[FloatArray, FloatArray, int]:
    """Mean force [N] before each sample of (samples,), its drop within one slip [N], and the samples of a mean."""
    side = max(3, round(SIDE / step))
    lag = side + max(1, round(DURATION / step))
    means = uniform_filter1d(force, side)[side:-side]
    return means[:-lag], means[:-lag] - means[lag:], side


def _measure(run: RunView) -> Estimate:
    """The largest of many noisy slips is too large: each half of the samples measures the one that the other half
    takes for the largest."""
    run.require_unbroken_hold()
    events = run.events
    window = run.window(events.on + CLEAR, events.off - CLEAR, least=200)
    force = run.force[window] - run.zero.value
    level, drops, side = slips(force, run.step)
    noise = run.noise_moving
    weights = np.zeros(2 * side)
    weights[:side], weights[-side:] = 1.0 / side, -1.0 / side
    sd = noise.sd(weights)
    largest = int(np.argmax(drops))
    if drops[largest] < THRESHOLD * sd or level[largest] < THRESHOLD * sd:
        raise Unusable("no_slip")
    fraction = float(drops[largest] / level[largest])
    count = len(force) // 2
    halves = [slips(part[:count], 2 * run.step)[:2] for part in (force[::2], force[1::2])]
    places = [int(np.argmax(shown)) for _, shown in halves]
    other = [float(found[at] / levels[at]) for at, (levels, found) in zip(places, halves[::-1], strict=True)]
    value = min(fraction, max(0.0, float(np.mean(other))))
    level_sd = math.hypot(noise.sd(np.full(side, 1.0 / side)), run.zero.sd)
    own = math.hypot(sd, value * level_sd) / float(level[largest])
    unknown_zero = value * UNKNOWN_ZERO_SD / float(level[largest]) if run.zero.reason else 0.0
    # two slips that each half takes for the largest
    apart = 0.5 * abs(other[0] - other[1]) if abs(places[0] - places[1]) > side else 0.0
    known = max(own, apart)
    return Estimate(value, math.hypot(known, unknown_zero), sd_zero_known=known)


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "slip_fraction",
            "1",
            "hold",
            "largest drop in one slip while driven over the force before that slip: means of 1.5 ms, 2 ms apart",
        ),
        _measure,
    ),
)
