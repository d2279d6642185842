"""Stick-slip while driven: how much of the force the largest slip lets go."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d
from scipy.special import ndtr

from eaclutch.records import FloatArray, ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

SIDE = 0.0015  # s of mean force on either side of a slip
DURATION = 0.002  # s: a slip lasts about half a period of the load cell (0.8 ms)
THRESHOLD = 7.0  # standard deviations of the difference of two such means
TOP = 0.1  # of the way from the slip that one half shows to the largest of all: where the truth mostly lies
CLEAR = 0.001  # s kept clear of voltage on and off


def slips(force: FloatArray, step: float) -> tuple[FloatArray, FloatArray, int]:
    """Mean force [N] before each sample of (samples,), its drop within one slip [N], and the samples of a mean."""
    side = max(3, round(SIDE / step))
    lag = side + max(1, round(DURATION / step))
    means = uniform_filter1d(force, side)[side:-side]
    return means[:-lag], means[:-lag] - means[lag:], side


def _measure(run: RunView) -> Estimate:
    """The largest of many noisy slips is too large, as a peak is: see ``capacity.peak`` for the two halves."""
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
    halves = [slips(part[:count], 2 * run.step) for part in (force[::2], force[1::2])]
    other = []
    for (_, shown, _), (levels, found, _) in (halves, halves[::-1]):
        at = int(np.argmax(shown))
        other.append(found[at] / levels[at])
    held = min(fraction, max(0.0, float(np.mean(other))))
    value = held + TOP * (fraction - held)
    level_sd = math.hypot(noise.sd(np.full(side, 1.0 / side)), run.zero.sd)
    own = math.hypot(sd, value * level_sd) / float(level[largest])
    rivals = rivals_spread(level, drops, side, sd, value)
    # what rivals show apart holds the noise of each
    return Estimate(value, math.hypot(max(own, rivals), (fraction - held) / math.sqrt(12.0)))


def rivals_spread(level: FloatArray, drops: FloatArray, side: int, sd: float, value: float) -> float:
    """By how much the fraction of whichever slip is truly the largest may differ from ``value``.

    Slips whose drops differ by less than their noise ``sd`` [N] stand at different forces: each counts by the
    probability that its drop is the larger one.
    """
    slip = drops == maximum_filter1d(drops, 4 * side + 1)
    weight = ndtr((drops[slip] - drops.max()) / (math.sqrt(2.0) * sd))
    return float(np.sqrt(weight @ (drops[slip] / level[slip] - value) ** 2 / weight.sum()))


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
