"""Stick-slip while driven: how much of the force the largest slip lets go."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import FloatArray, ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.noise import Noise
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView
from eaclutch.rig.zero import UNKNOWN_ZERO_SD

SIDE = 0.0015  # s of mean force on either side of a slip
DURATION = 0.002  # s: a slip lasts about half a period of the load cell
HALF_PERIOD = 0.0008  # s, of the bare load cell
CLIMB = 0.004  # s of force on either side of a slip that tell how fast it climbs
STEEP = 5  # samples over which the fall is the steepest
THRESHOLD = 7.0  # standard deviations of the difference of two such means
CROWDED = 0.006  # s between two slips within which the means of one hold a part of the other
SHARP = 5.0  # standard deviations of a fall that is another slip
CLEAR = 0.001  # s kept clear of voltage on and off


@dataclass(frozen=True)
class Slips:
    """What a slip at each sample of a force (samples,) would be, by mean forces before and after it.

    level: mean force before [N]; drop: by how much the mean after is less [N]; both (samples - side - lag,).
    side, lag: samples of a mean, and from the first mean to the second.
    """

    force: FloatArray
    step: float
    level: FloatArray
    drop: FloatArray
    side: int
    lag: int

    @classmethod
    def of(cls, force: FloatArray, step: float) -> Slips:
        """Means of a force [N] sampled every ``step`` [s]."""
        side = max(3, round(SIDE / step))
        lag = side + max(1, round(DURATION / step))
        means = uniform_filter1d(force, side)[side:-side]
        return cls(force, step, means[:-lag], means[:-lag] - means[lag:], side, lag)

    def least(self, noise: Noise) -> float:
        """The drop [N] from which one is a slip and no noise."""
        weights = np.zeros(2 * self.side)
        weights[: self.side], weights[-self.side :] = 1.0 / self.side, -1.0 / self.side
        return THRESHOLD * noise.sd(weights)

    def ends(self, at: int) -> tuple[FloatArray, FloatArray, int]:
        """Weights of the force in the level at the top of slip ``at`` and in its drop from top to bottom, and the
        sample where both begin.

        Between slips the force climbs while the means are taken: they are carried on to the slip's two ends, half a
        period apart around its steepest fall, along the slope that both sides have in common.
        """
        before, after = at + self.side, at + self.side + self.lag
        half = self.side // 2
        first, last = self._between_slips(at)
        fall = self._steepest(at) + 0.5 * STEEP
        apart = 0.5 * HALF_PERIOD / self.step
        x = np.arange(first, last, dtype=float)
        sides = (x < before + half + 1, x > after - half - 1)
        slope = sum(np.where(here, x - x[here].mean(), 0.0) for here in sides)
        slope = slope / np.sum(slope**2)
        mean_before = (np.abs(x - before) <= half) / np.sum(np.abs(x - before) <= half)
        mean_after = (np.abs(x - after) <= half) / np.sum(np.abs(x - after) <= half)
        level = mean_before + (fall - apart - before) * slope
        return level, level - (mean_after + (fall + apart - after) * slope), first

    def crowded(self, at: int, noise: Noise) -> bool:
        """Whether another slip, half as steep or more, stands so near slip ``at`` that its means hold a part of it."""
        wide, steepest = round(CROWDED / self.step), self._steepest(at)
        start = max(steepest - wide, 0)
        falls = _falls(self.force[start : steepest + wide + 2 * STEEP])
        weights = np.zeros(2 * STEEP)
        weights[:STEEP], weights[STEEP:] = 1.0 / STEEP, -1.0 / STEEP
        least = max(0.5 * falls[steepest - start], SHARP * noise.sd(weights))
        others = np.abs(np.arange(len(falls)) - (steepest - start)) > round(2 * HALF_PERIOD / self.step)
        return bool(np.any(falls[others] > least))

    def _steepest(self, at: int) -> int:
        """The sample from which the force falls the most in slip ``at``."""
        before = at + self.side
        return before + int(np.argmax(_falls(self.force[before : before + self.lag + 1])))

    def _between_slips(self, at: int) -> tuple[int, int]:
        """The samples around slip ``at`` that no other slip and no end of the force spoils."""
        half, wide = self.side // 2, round(CLIMB / self.step)
        margin = round(HALF_PERIOD / self.step)
        before, after = at + self.side, at + self.side + self.lag
        others = np.flatnonzero(self.drop > 0.5 * self.drop[at])
        earlier, later = others[others < at - self.lag], others[others > at + self.lag]
        # at half its drop a slip stands in the middle of the mean before or after it
        first = int(earlier[-1]) + self.side + margin if len(earlier) else 0
        last = int(later[0]) + self.side + self.lag - margin if len(later) else len(self.force)
        first = min(max(first, before + half + 1 - wide, 0), before - half)
        return first, max(min(last, after - half + wide, len(self.force)), after + half + 1)


def _falls(force: FloatArray) -> FloatArray:
    """How far a force (samples,) falls from the ``STEEP`` samples around one to those around the ``STEEP``-th next."""
    smooth = uniform_filter1d(force, STEEP)
    return smooth[:-STEEP] - smooth[STEEP:]


def slips_between(run: RunView, start: float, end: float) -> bool:
    """Whether the force slips between two instants of the run's time [s]."""
    every = Slips.of(run.force[run.window(start, end)], run.step)
    return bool(np.max(every.drop, initial=0.0) > every.least(run.noise_moving))


def _measure(run: RunView) -> Estimate:
    """The largest of many noisy slips is too large: each half of the samples measures the one that the other half
    takes for the largest."""
    run.require_unbroken_hold()
    events = run.events
    window = run.window(events.on + CLEAR, events.off - run.off_doubt - CLEAR, least=200)
    force = run.force[window] - run.zero.value
    every = Slips.of(force, run.step)
    noise = run.noise_moving
    least = every.least(noise)
    largest = int(np.argmax(every.drop))
    if every.drop[largest] < least or every.level[largest] < least:
        raise Unusable("no_slip")
    if every.crowded(largest, noise):
        raise Unusable("slips_crowded")
    of_level, of_drop, start = every.ends(largest)
    part = force[start : start + len(of_drop)]
    level = float(of_level @ part)
    carried = float(of_drop @ part) - float(every.drop[largest]), level - float(every.level[largest])
    count = len(force) // 2
    halves = [Slips.of(samples[:count], 2 * run.step) for samples in (force[::2], force[1::2])]
    places = [int(np.argmax(shown.drop)) for shown in halves]
    fraction = float(of_drop @ part) / level
    other = [
        float((found.drop[at] + carried[0]) / (found.level[at] + carried[1]))
        for at, found in zip(places, halves[::-1], strict=True)
    ]
    value = min(fraction, max(0.0, float(np.mean(other))))
    level_sd = math.hypot(noise.sd(of_level), run.zero.sd)
    own = math.hypot(noise.sd(of_drop), value * level_sd) / level
    unknown_zero = value * UNKNOWN_ZERO_SD / level if run.zero.reason else 0.0
    # two slips that each half takes for the largest
    apart = 0.5 * abs(other[0] - other[1]) if abs(places[0] - places[1]) > every.side else 0.0
    known = max(own, apart)
    return Estimate(value, math.hypot(known, unknown_zero), sd_zero_known=known)


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "slip_fraction",
            "1",
            "hold",
            "largest drop in one slip while driven over the force before it: means of 1.5 ms, carried on to its ends",
        ),
        _measure,
    ),
)
