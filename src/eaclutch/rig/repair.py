"""Make a recording whole where that is certain, and say where the force stands against the voltage.

Time, single samples and whole columns are treated in turn. A force column that lost lines is put back in step only
where an event shows its shift: the rise after voltage on, the drop after voltage off (rig/columns_in_step.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from eaclutch.records import Recording
from eaclutch.rig.columns_in_step import (
    lost_lines,
    moved_right,
    sample_spacing,
    stuck,
    unbroken_time,
    without_glitches,
)
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.events import LOST, find_events
from eaclutch.rig.force_events import find_drop, find_rise, is_torn

# Where the force's events may lie around the voltage's, where nothing was lost [s]. The link loses lines by the
# hundred (4 ms and more), so that these leave no doubt.
BEFORE_OFF, AFTER_OFF = 0.001, 0.0025
AROUND_ON, RISE_SD = 0.003, 0.0012
SPACING = 78.125e-6  # s between the rig's samples


@dataclass(frozen=True)
class Whole:
    """A repaired recording. ``on_shift``, ``off_shift``: by how many samples the force still stands too early
    around voltage on and off; 0 where it is in step, NaN where that is not known. ``holes_while_driven``: lines of
    the force were (or may have been) lost between the two."""

    recording: Recording
    on_shift: float = 0.0
    off_shift: float = 0.0
    holes_while_driven: bool = False


def repair(recording: Recording) -> Recording:
    """The recording with what could be repaired with certainty; flags say what was found and done."""
    return make_whole(recording).recording


def make_whole(recording: Recording, finishes: bool | None = None) -> Whole:
    """Repair a recording as logged, and tell where its force column stands (see ``Whole``); ``finishes``: as in
    ``find_events``."""
    time, flags = unbroken_time(recording.time)
    force, lost = recording.force, lost_lines(recording.force)
    kept = len(force) - lost
    mended, found = without_glitches(force[:kept])
    force = np.concatenate([mended, np.full(lost, np.nan)])
    flags += found
    if stuck(force[:kept]):
        flags += ("force_stuck",)
        if np.ptp(force[:kept]) == 0:
            force = np.full(len(force), np.nan)  # a cell that was not connected has measured nothing
    if abs(sample_spacing(time) / SPACING - 1.0) > 0.02:
        flags += ("other_sample_rate",)
    flag = np.where(np.isfinite(recording.flag), recording.flag, 0.0)
    voltage = np.where(np.isfinite(recording.voltage), recording.voltage, 0.0)
    if lost_lines(voltage):
        flags += (LOST,)
    whole = replace(
        recording, time=time, force=force, flag=flag, voltage=voltage, flags=(*recording.flags, *flags)
    )
    if lost == 0:
        return Whole(whole)
    whole = replace(whole, flags=(*whole.flags, "force_lines_lost"))
    if "time_broken" in flags:
        return Whole(whole, np.nan, np.nan, True)
    try:
        return _in_step(whole, lost, finishes)
    except Unusable:
        return Whole(whole, np.nan, np.nan, True)


def _in_step(recording: Recording, lost: int, finishes: bool | None) -> Whole:
    """Move the force where the shift around an event is known. Raises Unusable without events."""
    time, force = recording.time, recording.force
    events = find_events(recording, in_step=False, finishes=finishes)
    step = sample_spacing(time)
    kept = len(force) - lost

    drop = find_drop(time[:kept], force[:kept], events, lost * step)
    rise = find_rise(time[:kept], force[:kept], events, lost * step)
    off_shift = np.nan if drop is None else (events.off - drop) / step
    on_shift = np.nan if rise is None or rise.sd > RISE_SD else (events.on - rise.value) / step

    def rises(shift: float) -> bool:
        return abs(on_shift - shift) < AROUND_ON / step

    def falls(shift: float, later: float) -> bool:
        return -AFTER_OFF / step < off_shift + later / step - shift < BEFORE_OFF / step

    before = 0.0 if rises(0) else on_shift
    # lost before the voltage came: nothing stands in its place since
    all_before = rises(lost) and not rises(0)
    later = [0.0]
    if events.left_open and (finishes is None or all_before):
        # what was lost may be as long as a half wave that the drive finished, or did not
        ends = [find_events(recording, in_step=False, finishes=choice).off for choice in (True, False)]
        later = [end - events.off for end in ends]
    shifts = (lost,) if all_before else (0, lost)
    fits = [shift for shift in shifts if any(falls(shift, end) for end in later)]
    if len(fits) != 1 or drop is None or is_torn(time[:kept], force[:kept], drop):
        # lost in several places, or not to be told: the events' own times in the force are all there is
        return Whole(_flagged(recording, "force_not_in_step"), before, off_shift, True)
    if fits[0] == 0:
        # nothing was lost before release: all is in step until then
        return Whole(_flagged(recording, "force_in_step_until_release"))
    if rises(lost):
        # everything was lost before the voltage: all of that moves
        start = int(np.searchsorted(time, events.on - 0.6)) - lost
        moved = moved_right(force, max(start, 0), lost)
        return Whole(_flagged(replace(recording, force=moved), "force_realigned"))
    # lost while driven, at an unknown place: what comes after the middle of the hold moves
    start = int(np.searchsorted(time, 0.5 * (events.on + events.off))) - lost // 2
    moved = moved_right(force, start, lost)
    return Whole(_flagged(replace(recording, force=moved), "force_realigned_from_release"), before, 0.0, True)


def _flagged(recording: Recording, flag: str) -> Recording:
    return replace(recording, flags=(*recording.flags, flag))
