"""Does the drive finish its half wave where the sensed electrode is the grounded one? Only the force shows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import FloatArray, Recording
from eaclutch.rig.columns_in_step import sample_spacing
from eaclutch.rig.noise import noise_of

HELD = 0.003  # s before the flag falls that give the level held
SETTLED = (0.01, 0.11)  # s after the half wave's end that give the last level
QUIET = 0.1  # s before the flag falls that give the noise
LEFT = 0.05  # of its way that a force has done where it has left its hold, beyond noise
CLEAR = 4.0  # standard deviations
RELEASED = 0.0015  # s after which a released force swings round its last level
GONE = 0.9  # of its way that a force does in a release, though it may swing back, and in no slip
UNSEEN = 0.0003  # s for which a force may hold by itself, the film still closed
SHORT = 0.00075  # s for which a film may well stay closed after its voltage
LONG = 0.0045  # s for which none holds by itself and then lets go just as a half wave ends
NEAR = 3.0  # samples from a polarity edge that was not seen but reckoned
FEWEST = 2  # runs that show a drive's habit
AGREE = 0.85  # share of them
REACH = 2.0  # times as many half waves as were seen, beyond which their ends are not known to a sample


@dataclass(frozen=True)
class Unseen:
    """Whether the drive went on, unseen, after the flag's last sample (``driven``), and until when (``end``) [s]; None
    where that is unclear. ``shows``: whether the force shows by itself that this drive finishes its half waves, or that
    it does not; None where it shows neither."""

    end: float
    driven: bool | None
    shows: bool | None = None


def unseen_wave(
    recording: Recording,
    high: np.ndarray,
    last: int,
    half_period: float,
    *,
    whole: bool,
    in_step: bool,
    finishes: bool | None = None,
) -> Unseen:
    """What the drive did, unseen, after the flag's ``last`` sample.

    ``high``: whether the sensed electrode carries the voltage, (samples,); ``whole``: no lines of that column are lost;
    ``in_step``: the force stands where the time says; ``finishes``: what other runs say of this drive, which counts
    where this one's force has hardly time to tell.
    """
    time, force = recording.time, recording.force
    step = sample_spacing(time)
    fall = float(0.5 * (time[last] + time[last + 1]))
    if whole:
        sensed = np.flatnonzero(high[: last + 1])
        # grounded when the flag falls: the half wave ends half a period after the last polarity edge
        end = float(time[sensed[-1]]) + 0.5 * step + half_period if len(sensed) else fall
        if not time[last] + 1.5 * step < end < time[last] + half_period + 1.5 * step:
            return Unseen(fall, False)
        with_a_wave = bool(sensed[-1] > last - 2)
    else:
        # whether the force holds long after the flag, which it does by itself for no time like that
        holds = in_step and half_period > LONG and outlives(time, force, fall, fall + LONG)
        reckoned = _wave_end(time, high, fall, half_period)
        if reckoned is None:
            return Unseen(fall + half_period, None if holds else False)
        end = reckoned + (half_period if reckoned - fall < NEAR * step else 0.0)
        with_a_wave = half_period - (end - fall) < NEAR * step
        if holds and end - fall > LONG and outlives(time, force, fall, end) is False:
            return Unseen(end, None)  # let go long after the flag, and before the half wave's end
    if with_a_wave:
        # most drives end there, some have just begun another wave
        if in_step and not whole and finishes is not False and end - fall < SHORT:
            # of either electrode, and nothing of it is seen: a force that holds until its end may have been driven
            return Unseen(end, None if outlives(time, force, fall, end) else False)
        return Unseen(end, begins_another(time, force, fall, end) if in_step else False)
    return _by_the_force(time, force, fall, end, whole=whole, in_step=in_step, finishes=finishes)


def _by_the_force(
    time: FloatArray,
    force: FloatArray,
    fall: float,
    end: float,
    *,
    whole: bool,
    in_step: bool,
    finishes: bool | None,
) -> Unseen:
    """Whether the half wave that the flag's ``fall`` [s] lies in was driven to its ``end`` [s]: ``unseen_wave``."""
    felt = outlives(time, force, fall, end) if in_step else None
    if felt is not None and end - fall > SHORT:
        return Unseen(end, felt, felt if whole else None)
    if finishes is not None:
        return Unseen(end, finishes)
    return Unseen(end, felt if in_step else True)


def habit(shown: Sequence[bool | None]) -> bool | None:
    """Whether a drive finishes its half waves after the flag, from what its runs show; None where too few show it or
    they do not agree. It is one driver: most finish them, others stop with the flag."""
    clear = [value for value in shown if value is not None]
    share = float(np.mean(clear)) if len(clear) >= FEWEST else 0.5
    return None if 1.0 - AGREE < share < AGREE else share > 0.5


def _wave_end(time: FloatArray, high: np.ndarray, until: float, half_period: float) -> float | None:
    """End [s] of the half wave that ``until`` [s] lies in, where the sensed voltage has lost lines: its polarity edges
    are regular as far as it is whole, and the drive goes on like that. None where they do not reach that far."""
    step = sample_spacing(time)
    before = np.flatnonzero(high[1:] != high[:-1])
    edges = 0.5 * (time[before] + time[before + 1])
    edges = edges[edges < until]
    odd = np.abs(np.diff(edges) - half_period) > max(2.0 * step, 0.02 * half_period)
    seen = int(np.flatnonzero(odd)[0]) if odd.any() else len(edges) - 1
    if seen < 1:
        return None
    period = float(edges[seen] - edges[0]) / seen
    ahead = int(np.ceil((until - edges[seen]) / period))
    return float(edges[seen]) + ahead * period if ahead <= REACH * seen else None


def outlives(time: FloatArray, force: FloatArray, fall: float, end: float) -> bool | None:
    """Whether the voltage went on from the flag's ``fall`` to its half wave's ``end`` [s]; None where that is unclear.

    ``time`` [s] and ``force`` [N], (samples,). A force that has left its hold before the end was released before; one
    that still holds there was driven until then, unless the two are so close that the film would not have opened yet.
    """
    step = sample_spacing(time)
    marks = [fall - QUIET, fall - HELD, fall, end - 1.5 * step, end + 0.5 * step, *(end + s for s in SETTLED)]
    quiet, before, at, first, last, early, late = np.searchsorted(time, marks)
    windows = [force[quiet:at], force[before:at], force[first:last], force[early:late]]
    if any(len(part) == 0 or not np.isfinite(part).all() for part in windows):
        return None
    noise = noise_of(windows[0], step)
    held = float(np.median(windows[1]))
    way = held - float(np.median(windows[3]))
    if noise is None or way < CLEAR * noise.white_sd:
        return None
    done = (held - float(np.mean(windows[2]))) / way
    doubt = CLEAR * noise.white_sd / (np.sqrt(len(windows[2])) * way)
    meanwhile = uniform_filter1d(force[at:last], len(windows[2]), mode="nearest")
    if (held - float(np.min(meanwhile))) / way > GONE:
        return False
    if done > (0.5 if end - fall > RELEASED else LEFT + doubt):
        return False
    return True if end - fall > UNSEEN else None


def begins_another(time: FloatArray, force: FloatArray, fall: float, end: float) -> bool | None:
    """Whether a drive whose flag fell with a wave's end had just begun another, unseen half wave, until ``end`` [s];
    None where that is unclear. Arguments as in ``outlives``.

    Only a force that holds until then and lets go there says so. A film that is slow to open does the same: in a short
    half wave it is taken for that, and only in a long one not.
    """
    if end - fall < SHORT or not outlives(time, force, fall, end):
        return False
    step = sample_spacing(time)
    marks = (fall - HELD, fall, end + RELEASED, end + 2 * RELEASED, *(end + s for s in SETTLED))
    before, at, first, last, early, late = np.searchsorted(time, marks)
    held, settled = float(np.median(force[before:at])), float(np.median(force[early:late]))
    if np.median(force[first : last + 1]) > 0.5 * (held + settled):
        return False
    return True if end - fall > LONG - step else None
