"""When the voltage came on and went off, from the flag and the sensed electrode (rig.md: A log)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import DC_LABEL, FloatArray, Recording
from eaclutch.rig.columns_in_step import sample_spacing
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.hidden_wave import unseen_wave

LOST = "voltage_lines_lost"  # flag of a voltage column whose edges cannot be trusted
MAJORITY = 5  # samples whose majority is the flag: a single sample that lost a digit is no edge
CUT = 2.0  # samples by which a wave that the drive cuts short is shorter
SENSED_HIGH = 50.0  # V, above this the sensed electrode carries the high voltage


@dataclass(frozen=True)
class Events:
    """Instants in the run's own time [s], each with its standard uncertainty; indices of the first sample after.

    ``stage_stop`` is when the stage came to rest: travel / speed after the voltage came on. ``finishes``: whether this
    run shows that the drive goes on after its flag until the half wave is whole; None where it shows neither.
    ``left_open``: whether off would stand elsewhere if other runs showed what this one does not.
    """

    on: float
    on_sd: float
    on_index: int
    off: float
    off_sd: float
    off_index: int
    stage_stop: float
    flags: tuple[str, ...] = ()
    finishes: bool | None = None
    left_open: bool = False

    @property
    def drive_duration(self) -> float:
        """Voltage on to off [s]."""
        return self.off - self.on

    @property
    def dwell(self) -> float:
        """How long the stage stood before the voltage fell [s]."""
        return max(0.0, self.off - self.stage_stop)


def find_events(recording: Recording, *, in_step: bool = True, finishes: bool | None = None) -> Events:
    """Voltage on and off of one run; ``in_step``: whether its force column is known to stand in step with the voltage;
    ``finishes``: whether other runs say that the drive finishes its half waves (``hidden_wave.habit``).

    On is the flag's rise: the sensed electrode may be the grounded one for the first half period. Off is the
    later of the flag's fall and the sensed voltage's. Where the sensed electrode is the grounded one at the end, the
    driver may still finish its half wave: the force then tells the polarity edge from the flag (``outlives``), where
    it cannot, other runs do, and where they cannot, off lies anywhere between (``voltage_off_unsure``). A flag that
    falls with a wave's end is off, unless the force says that the drive had begun another one (``begins_another``).
    Where the voltage's column has lost lines the waves are reckoned from those before (``unseen_wave``). A voltage
    that comes or stays by more than half a period later than the flag shows a flag that lost lines: then the voltage
    counts (``flag_early``), to half a period.
    Raises Unusable (``no_flag``, ``flag_never_falls``, ``no_voltage``, ``time_broken``).
    """
    time = recording.time
    flag = uniform_filter1d((recording.flag > 0.5).astype(float), MAJORITY, mode="nearest") > 0.5
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
    step = sample_spacing(time)
    if not step > 0:
        raise Unusable("time_broken")
    dc = recording.settings.frequency <= DC_LABEL
    half_period = 0.0 if dc else 0.5 / recording.settings.frequency
    flags, unsure = [], [0.0, 0.0]
    shown: bool | None = None
    left_open = False
    if time[sensed[0]] - time[first] > half_period + 3 * step:
        first, unsure[0] = int(sensed[0]), half_period
        flags.append("flag_early")
    # the wave that is on when the flag falls goes on until its own end
    after = last + _run_length(high[last + 1 :])
    goes_on = _waves(high[after + 1 :], round(half_period / step) + 3)
    if goes_on:
        after, unsure[1] = after + goes_on, half_period
        flags.append("flag_early")
    elif time[after] - time[last] > 3 * step:
        flags.append("voltage_outlives_flag")
        shown = True
    whole = LOST not in recording.flags
    if whole and shown is None and high[last] and _cut_short(high[: after + 1], half_period / step):
        shown = False
    if after == last and half_period > 3 * step:
        unseen = unseen_wave(
            recording, high, last, half_period, whole=whole, in_step=in_step, finishes=finishes
        )
        shown = unseen.shows if shown is None else shown
        # a flag that falls with a whole wave says nothing of the drive, nor the drive of it
        left_open = shown is None and not (whole and high[max(last - 1, 0) : last + 1].any())
        if unseen.driven:
            after = int(np.searchsorted(time, unseen.end)) - 1
            flags.append("voltage_outlives_flag")
        elif unseen.driven is None:
            unsure[1] = unseen.end - 0.5 * float(time[last] + time[last + 1])
            flags.append("voltage_off_unsure")
    on, on_sd, on_index = _between(time, first - 1)
    off, off_sd, off_index = _between(time, min(after, len(time) - 2))
    # a half wave more, of the other electrode, may lie before what is sensed, and behind it
    on, off = on - 0.5 * unsure[0], off + 0.5 * unsure[1]
    on_sd, off_sd = (
        math.hypot(sd, wide / math.sqrt(12.0)) for sd, wide in zip((on_sd, off_sd), unsure, strict=True)
    )
    travel_time = recording.settings.travel / recording.settings.speed
    return Events(
        on,
        on_sd,
        on_index,
        off,
        off_sd,
        off_index,
        on + travel_time,
        tuple(dict.fromkeys(flags)),
        shown,
        left_open,
    )


def _cut_short(high: np.ndarray, half_period: float) -> bool:
    """Whether the wave that ``high`` (samples,) ends with is clearly shorter than ``half_period`` [samples]."""
    return _run_length(high[::-1]) < half_period - CUT


def _run_length(high: np.ndarray) -> int:
    """How many samples from the first on are high without a break."""
    low = np.flatnonzero(~high)
    return int(low[0]) if len(low) else len(high)


def _waves(high: np.ndarray, gap: int) -> int:
    """How far waves go on that follow each other within ``gap`` samples; 0 for none (a stray sample is none)."""
    index = np.flatnonzero(high)
    breaks = np.flatnonzero(np.diff(np.concatenate([[-1], index])) > gap)
    index = index[: breaks[0]] if len(breaks) else index
    return int(index[-1]) + 1 if len(index) >= MAJORITY else 0


def _between(time: FloatArray, before: int) -> tuple[float, float, int]:
    """The middle between sample ``before`` and the next, its uniform uncertainty, and the next one's index."""
    before = max(before, 0)
    low, high = time[before], time[before + 1]
    return float(0.5 * (low + high)), float((high - low) / np.sqrt(12.0)), before + 1
