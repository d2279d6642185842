"""One run as the observables see it: whole columns, events, levels, zero, noise; each worked out once."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, TypeVar

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import FloatArray
from eaclutch.rig.columns_in_step import GAP, sample_spacing
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.events import SENSED_HIGH, Events, find_events
from eaclutch.rig.noise import Noise, noise_of
from eaclutch.rig.repair import Whole
from eaclutch.rig.zero import find_zero

T = TypeVar("T")
BLOCK = 0.1  # s of which the noise tells the mean's uncertainty; longer means are of independent blocks
SETTLING = 0.15  # s after the voltage falls, until which the force may still ring
SLIP_SAMPLES = 7  # over which the force before the voltage falls is smoothed: fewer than a slip lasts
BEFORE_ON = 0.02  # s, one period of the stage's full steps (50 Hz)
# Samples after an edge of the voltage in which the drive is seen in the force (the ADC's filter delays it by two).
PICK_UP_ON, PICK_UP_EDGE = (1.2, 4.8), (1.2, 3.8)
# N s/V: what rising and falling edge leave together in the force, 0 +- this (published logs: up to 2.2e-9)
PICK_UP_NET = 1.8e-9
FEWEST_BETWEEN_EDGES = 20  # samples: faster drives leave nothing to look at between their edges
LAST = 0.003  # s before voltage off that give the force there
MARGIN = 0.002  # s kept clear of the force's own events where the column is not in step


class _Reason(str):
    """Why a family of observables has no values."""


@dataclass(frozen=True)
class RunView:
    """A repaired recording with what all observables share; ``finishes``: what other runs say of the drive (events)."""

    whole: Whole
    finishes: bool | None = None
    done: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    def once(self, name: str, work: Callable[[RunView], T]) -> T:
        """What ``work`` makes of this run; done once for the observables of a family. Raises Unusable."""
        if name not in self.done:
            try:
                self.done[name] = work(self)
            except Unusable as reason:
                self.done[name] = _Reason(
                    str(reason)
                )  # an exception would keep its frames, and so the run, alive
        found = self.done[name]
        if isinstance(found, _Reason):
            raise Unusable(found)
        return found

    @property
    def time(self) -> FloatArray:
        """[s], (samples,)"""
        return self.whole.recording.time

    @property
    def force(self) -> FloatArray:
        """As logged [N], the zero not taken off, (samples,); NaN where lines were lost."""
        return self.whole.recording.force

    @cached_property
    def step(self) -> float:
        """Sample spacing [s]."""
        return sample_spacing(self.time)

    @cached_property
    def events(self) -> Events:
        """The voltage's events. Raises Unusable."""
        if "time_broken" in self.whole.recording.flags:
            raise Unusable("time_broken")
        in_step = self.whole.off_shift == 0.0
        return find_events(self.whole.recording, in_step=in_step, finishes=self.finishes)

    @cached_property
    def force_on(self) -> float:
        """Where voltage on stands in the force column [s]: ``events.on``, but for lost lines. Raises Unusable."""
        shift = self.whole.on_shift
        if math.isnan(shift):
            raise Unusable("force_not_in_step")
        return self.events.on - shift * self.step - (MARGIN if shift else 0.0)

    @cached_property
    def force_off(self) -> float:
        """Where voltage off stands in the force column [s]: ``events.off``, but for lost lines. Raises Unusable."""
        shift = self.whole.off_shift
        if math.isnan(shift):
            raise Unusable("force_not_in_step")
        return self.events.off - shift * self.step

    @property
    def off_doubt(self) -> float:
        """By how much voltage off may stand before or behind ``events.off`` [s]; 0 where it is known to a sample."""
        sd = self.events.off_sd
        return math.sqrt(3.0) * sd if sd > self.step else 0.0

    def require_in_step(self, event: Literal["on", "off"]) -> None:
        """Raise Unusable unless the force is in step with the voltage around an event."""
        if (self.whole.on_shift if event == "on" else self.whole.off_shift) != 0.0:
            raise Unusable("force_not_in_step")

    def require_unbroken_hold(self) -> None:
        """Raise Unusable where lines of the force may have been lost while driven."""
        if self.whole.holes_while_driven:
            raise Unusable("force_lines_lost")

    @property
    def slow_drive(self) -> bool:
        """Whether the polarity edges leave samples between them."""
        return 0.5 / self.whole.recording.settings.frequency > FEWEST_BETWEEN_EDGES * self.step

    @property
    def drive_offset_sd(self) -> float:
        """By how much the drive's edges may shift the mean force [N]: those of a slow drive are left out one by one."""
        settings = self.whole.recording.settings
        return 0.0 if self.slow_drive else PICK_UP_NET * settings.frequency * settings.voltage

    @cached_property
    def pick_up(self) -> np.ndarray:
        """Samples (bool, (samples,)) just after the voltage's edges, in which the drive is seen in the force.

        Polarity edges count where the drive is slow enough to leave samples between them.
        """
        events, voltage = self.events, self.whole.recording.voltage
        edges = np.flatnonzero(np.diff((voltage > SENSED_HIGH).astype(int)))
        edges = edges[(edges >= events.on_index) & (edges < events.off_index)]
        seen = [(events.on, PICK_UP_ON), (events.off, PICK_UP_EDGE)]
        if len(edges):
            first_high = float(self.time[edges[0]] + 0.5 * self.step)
            seen.append((first_high, PICK_UP_ON))
        if self.slow_drive:
            seen += [(float(self.time[edge] + 0.5 * self.step), PICK_UP_EDGE) for edge in edges]
        found = np.zeros(len(self.time), dtype=bool)
        for edge, (start, end) in seen:
            first, last = np.searchsorted(self.time, [edge + start * self.step, edge + end * self.step])
            found[first:last] = True
        return found

    def window(self, start: float, end: float, *, least: int = 4, whole: bool = True) -> slice:
        """Samples with start <= time < end. Raises Unusable where they are too few or, if ``whole``, interrupted."""
        first, last = (int(i) for i in np.searchsorted(self.time, [start, end]))
        if last - first < least or start < self.time[0] - self.step or end > self.time[-1] + self.step:
            raise Unusable("too_short")
        if not whole:
            return slice(first, last)
        if not np.isfinite(self.force[first:last]).all():
            raise Unusable("force_lines_lost")
        if (
            "time_gap" in self.whole.recording.flags
            and np.diff(self.time[first:last]).max() > GAP * self.step
        ):
            raise Unusable("time_gap")
        return slice(first, last)

    @cached_property
    def noise_moving(self) -> Noise:
        """Noise while the stage moves, from the second before the voltage. Raises Unusable."""
        return self._noise(self.force_on - 1.2, self.force_on - 0.002)

    @cached_property
    def noise_rest(self) -> Noise:
        """Noise while the stage rests, from the time after release. Raises Unusable."""
        try:
            return self._noise(self.force_off + SETTLING, self.time[-1])
        except Unusable:
            return self.noise_moving

    def _noise(self, start: float, end: float) -> Noise:
        first, last = np.searchsorted(self.time, [start, end])
        noise = noise_of(self.force[first:last], self.step)
        if noise is None:
            raise Unusable("no_noise")
        return noise

    @cached_property
    def zero(self) -> Estimate:
        """The force without contact [N]; 0 with the reason ``no_zero`` where the run does not show it."""
        try:
            return find_zero(self.time, self.force, self.force_on)
        except Unusable:
            return Estimate(0.0, 0.0, "no_zero")

    def mean(self, start: float, end: float, noise: Noise) -> Estimate:
        """Mean force [N] of a window, with the noise's share of its uncertainty."""
        window = self.window(start, end)
        count = window.stop - window.start
        block = min(count, max(4, round(BLOCK / self.step)))
        sd = noise.sd(np.full(block, 1.0 / block)) * math.sqrt(block / count)
        return Estimate(float(np.mean(self.force[window])), sd)

    @cached_property
    def friction_level(self) -> Estimate:
        """Mean force over the 0.5 s before the voltage [N], the zero not taken off. Raises Unusable."""
        return self.mean(self.force_on - 0.5, self.force_on, self.noise_moving)

    @cached_property
    def force_before_on(self) -> Estimate:
        """Force just before the voltage [N]: mean over one period of the stage's steps. Raises Unusable."""
        return self.mean(self.force_on - BEFORE_ON, self.force_on, self.noise_moving)

    @cached_property
    def switch_off_level(self) -> Estimate:
        """Median force of the last 3 ms in which the voltage is surely on [N]. Raises Unusable."""
        if self.off_doubt > 0.5 * LAST:
            raise Unusable("off_unsure")
        off = self.force_off - self.off_doubt
        window = self.window(off - LAST, off, least=10)
        force = self.force[window]
        # a slip within the window makes the median jump between two levels: noise goes onto the smoothed force
        smooth = uniform_filter1d(force, SLIP_SAMPLES)
        drawn = np.median(smooth + self.noise_moving.windows(len(force), 160), axis=1)
        # noise draws the median of a skew window towards its mean, by about as much as it does once more
        drawn_away = float(np.mean(drawn)) - float(np.median(smooth))
        # the smoothed force keeps a share of the noise, which spreads the window and widens its medians as much
        spread = float(np.std(drawn)) / math.sqrt(1.0 + 1.0 / SLIP_SAMPLES)
        sd = math.hypot(spread, drawn_away, self.drive_offset_sd)
        return Estimate(float(np.median(force)), sd)

    @cached_property
    def final_level(self) -> Estimate:
        """Mean force 10 to 110 ms after the voltage has surely fallen [N]. Raises Unusable."""
        off = self.force_off + self.off_doubt
        return self.mean(off + 0.010, off + 0.110, self.noise_rest)
