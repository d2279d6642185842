"""The two events that the force itself shows: its rise after the voltage came on, its drop after it fell."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import FloatArray
from eaclutch.rig.columns_in_step import sample_spacing
from eaclutch.rig.estimate import Estimate
from eaclutch.rig.events import Events
from eaclutch.rig.noise import noise_of
from eaclutch.rig.onset import onset

REST = 0.2  # s of force after release that give its last level
HELD = 0.02  # s over which the level before the drop is taken
RINGING = 0.008  # s of ring-down that is skipped
TEAR = 0.4  # of the way between two samples; the load cell takes five samples at least
FALL = 8  # samples, what release takes at most
LEVEL = 20  # samples before a fall that give where it starts
SOON = 13  # samples after it in which a release has come to the last level, or swung through it
SLIP = 0.1  # of the way to the last level that a slip while driven leaves at least
CLEAR = 6.0  # standard deviations


def find_drop(time: FloatArray, force: FloatArray, events: Events, early: float) -> float | None:
    """When the force leaves its hold for good [s], looked for from ``early`` before voltage off; None if unclear.

    Taken back from the half-way point along the steepest line to the level before.
    """
    step = sample_spacing(time)
    first, last = np.searchsorted(time, [events.off - early - 0.05, events.off + 0.02])
    rest = force[np.searchsorted(time, time[-1] - REST) :]
    if last - first < 100 or len(rest) < 100:
        return None
    part = force[first:last]
    final, noise = float(np.median(rest)), _noise(rest)
    before, gap, after = (max(3, round(seconds / step)) for seconds in (HELD, RINGING, HELD))
    sums = np.concatenate([[0.0], np.cumsum(part)])
    at = np.arange(before, len(part) - gap - after)
    if len(at) < 10:
        return None
    held = (sums[at] - sums[at - before]) / before
    left = (sums[at + gap + after] - sums[at + gap]) / after
    height = held - left
    # a slip while driven ends above the last level, release ends there
    height[np.abs(left - final) > 0.25 * np.abs(held - final) + 3.0 * noise / np.sqrt(after)] = -np.inf
    best = int(np.argmax(height))
    if height[best] < CLEAR * noise / np.sqrt(5):
        return None
    # the steepest fall around there that does not end above the last level, as a slip just before release does; and
    # back to where the force was last at its level
    near = slice(int(at[best]) - gap, int(at[best]) + 2 * gap)
    smooth = uniform_filter1d(part, 5)[near]
    fall = smooth[FALL:] - smooth[:-FALL]
    start = 0
    while True:
        steepest = start + int(np.argmin(fall[start:]))
        ends = steepest + FALL
        before_it = part[near][max(start, steepest - LEVEL) : steepest]
        level = float(np.median(before_it)) if len(before_it) >= FALL else float(smooth[start])
        lowest = np.min(smooth[ends : ends + SOON], initial=np.inf)
        if lowest < final + max(SLIP * (level - final), CLEAR * noise / np.sqrt(5)):
            break
        if ends >= len(fall):
            return None
        start = ends
    back = start + np.flatnonzero(smooth[start:ends] > level - 0.15 * (level - final))
    return float(time[first + near.start + back[-1]]) - 2 * step if len(back) else None


def is_torn(time: FloatArray, force: FloatArray, drop: float) -> bool:
    """Whether the fall around ``drop`` [s] happens between two samples: lines are missing there, not a release."""
    marks = [drop - 0.012, drop - 0.002, drop + 0.004, drop + RINGING, drop + RINGING + HELD]
    early, before, after, settled, late = np.searchsorted(time, marks)
    held, left = force[early:before], force[settled:late]
    if len(held) < 10 or len(left) < 10:
        return True
    fall = -np.min(np.diff(force[before:after]))
    return bool(fall > TEAR * (np.median(held) - np.median(left)) + 2.0 * _noise(force[early:before]))


def find_rise(time: FloatArray, force: FloatArray, events: Events, early: float) -> Estimate | None:
    """When the force begins its rise [s], looked for from ``early`` before voltage on; None if unclear."""
    step = sample_spacing(time)
    marks = [events.on - early - 0.35, events.on - early - 0.05, events.on + 0.06]
    first, start, last = np.searchsorted(time, marks)
    quiet = force[first:start]
    noise = noise_of(quiet, step)
    if noise is None or last <= start:
        return None
    width = max(3, round(0.01 / step))  # half a period of the stage's steps at 50 Hz
    means = uniform_filter1d(force[first:last], width)
    spread = means[: start - first]
    above = means[start - first :] > spread.mean() + max(
        CLEAR * spread.std(), 2.0 * noise.white_sd / np.sqrt(width)
    )
    if not above[-1] or above[0]:
        return None
    crossing = float(time[start + int(np.flatnonzero(~above)[-1]) + 1])
    near = slice(*np.searchsorted(time, [crossing - 0.03, crossing + 0.01]))
    if near.stop - near.start < 300:
        return None
    everything = np.ones(near.stop - near.start, dtype=bool)
    found = onset(time[near] - crossing, force[near], everything, noise, (-0.02, 0.004))
    return Estimate(crossing + found.value, found.sd)


def _noise(force: FloatArray) -> float:
    return 1.4826 * float(np.median(np.abs(np.diff(force)))) / np.sqrt(2.0)
