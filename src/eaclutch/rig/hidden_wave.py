"""Does the drive finish its half wave where the sensed electrode is the grounded one? Only the force shows it."""

from __future__ import annotations

import numpy as np

from eaclutch.records import FloatArray
from eaclutch.rig.columns_in_step import sample_spacing
from eaclutch.rig.noise import noise_of

HELD = 0.003  # s before the flag falls that give the level held
SETTLED = (0.01, 0.11)  # s after the half wave's end that give the last level
QUIET = 0.1  # s before the flag falls that give the noise
LEFT = 0.05  # of its way that a force has done where it has left its hold, beyond noise
CLEAR = 4.0  # standard deviations
RELEASED = 0.0015  # s after which a released force swings round its last level
UNSEEN = 0.0003  # s for which a force may hold by itself, the film still closed
SHORT = 0.00075  # s for which a film may well stay closed after its voltage
LONG = 0.0045  # s for which none holds by itself and then lets go just as a half wave ends


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
