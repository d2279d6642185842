"""When the voltage came on and went off, from the flag and the sensed electrode (rig.md: A log)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eaclutch.records import FloatArray, Recording
from eaclutch.rig.columns_in_step import sample_spacing
from eaclutch.rig.estimate import Unusable

DC_LABEL = 0.1  # Hz, the rig's way to write DC
LOST = "voltage_lines_lost"  # flag of a voltage column whose edges cannot be trusted
SENSED_HIGH = 50.0  # V, above this the sensed electrode carries the high voltage


@dataclass(frozen=True)
class Events:
    """Instants in the run's own time [s], each with its standard uncertainty; indices of the first sample after.

    ``stage_stop`` is when the stage came to rest: travel / speed after the voltage came on.
    """

    on: float
    on_sd: float
    on_index: int
    off: float
    off_sd: float
    off_index: int
    stage_stop: float
    flags: tuple[str, ...] = ()

    @property
    def drive_duration(self) -> float:
        """Voltage on to off [s]."""
        return self.off - self.on

    @property
    def dwell(self) -> float:
        """How long the stage stood before the voltage fell [s]."""
        return max(0.0, self.off - self.stage_stop)


def find_events(recording: Recording) -> Events:
    """Voltage on and off of one run.

    On is the flag's rise: the sensed electrode may be the grounded one for the first half period. Off is the
    later of the flag's fall and the sensed voltage's; where the sensed electrode is the grounded one at the end,
    the driver still finishes its half wave, and the fall is taken from the polarity edges.
    Raises Unusable (``no_flag``, ``flag_never_falls``, ``no_voltage``).
    """
    time, flag = recording.time, recording.flag > 0.5
    driven = np.flatnonzero(flag)
    if len(driven) == 0:
        raise Unusable("no_flag")
    first, last = int(driven[0]), int(driven[-1])
    high = recording.voltage > SENSED_HIGH
    sensed = np.flatnonzero(high)
    if len(sensed) == 0:
        raise Unusable("no_voltage")
    if last >= len(time) - 2:
        raise Unusable("flag_never_falls")
    flags = []
    half_period = 0.5 / recording.settings.frequency
    dc = recording.settings.frequency <= DC_LABEL
    step = sample_spacing(time)
    late = time[sensed[0]] - time[first]
    if late > 3 * step and (dc or late > half_period + 3 * step):
        flags.append("voltage_late")
    after = last
    if sensed[-1] > last:
        after = int(sensed[-1])
        if time[after] - time[last] > 3 * step:
            flags.append("voltage_outlives_flag")
    elif not dc and LOST not in recording.flags and last - sensed[-1] >= 2 and half_period > 3 * step:
        fall = time[sensed[-1]] + 0.5 * step
        rest = fall + half_period
        if time[last] + 1.5 * step < rest < time[last] + half_period + 1.5 * step and fall > time[first]:
            after = min(int(np.searchsorted(time, rest)) - 1, len(time) - 2)
            flags.append("voltage_outlives_flag")
    on, on_sd, on_index = _between(time, first - 1)
    off, off_sd, off_index = _between(time, after)
    travel_time = recording.settings.travel / recording.settings.speed
    return Events(on, on_sd, on_index, off, off_sd, off_index, on + travel_time, tuple(flags))


def _between(time: FloatArray, before: int) -> tuple[float, float, int]:
    """The middle between sample ``before`` and the next, its uniform uncertainty, and the next one's index."""
    before = max(before, 0)
    low, high = time[before], time[before + 1]
    return float(0.5 * (low + high)), float((high - low) / np.sqrt(12.0)), before + 1
