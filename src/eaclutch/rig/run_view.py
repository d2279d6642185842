"""One run as the observables see it: aligned columns, events, levels, zero, noise; each worked out once."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from eaclutch.records import FloatArray, Recording
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.events import Events, find_events
from eaclutch.rig.noise import Noise, noise_of

SETTLING = 0.15  # s after the voltage falls, until which the force may still ring
BEFORE_ON = 0.02  # s, one period of the stage's full steps (50 Hz)


@dataclass(frozen=True)
class RunView:
    """A (repaired) recording with what all observables share.

    ``spoiled``: samples (bool, (samples,)) of the force that cannot be trusted or placed in time.
    """

    recording: Recording
    spoiled: np.ndarray
    zero: Estimate = field(default_factory=lambda: Estimate(0.0, 0.0))

    @property
    def time(self) -> FloatArray:
        """[s], (samples,)"""
        return self.recording.time

    @property
    def force(self) -> FloatArray:
        """As logged [N], the zero not taken off, (samples,)"""
        return self.recording.force

    @cached_property
    def step(self) -> float:
        """Sample spacing [s]."""
        return float(np.median(np.diff(self.time)))

    @cached_property
    def events(self) -> Events:
        """Raises Unusable."""
        return find_events(self.recording)

    def window(self, start: float, end: float, *, least: int = 4) -> slice:
        """Samples with start <= time < end. Raises Unusable where they are too few or spoiled."""
        first, last = np.searchsorted(self.time, [start, end])
        if last - first < least or start < self.time[0] - self.step or end > self.time[-1] + self.step:
            raise Unusable("too_short")
        if self.spoiled[first:last].any():
            raise Unusable("force_not_aligned")
        return slice(int(first), int(last))

    @cached_property
    def noise_moving(self) -> Noise:
        """Noise while the stage moves, from the second before the voltage. Raises Unusable."""
        return self._noise(self.events.on - 1.2, self.events.on - 0.002)

    @cached_property
    def noise_rest(self) -> Noise:
        """Noise while the stage rests, from the time after release. Raises Unusable."""
        try:
            return self._noise(self.events.off + SETTLING, self.time[-1])
        except Unusable:
            return self.noise_moving

    def _noise(self, start: float, end: float) -> Noise:
        first, last = np.searchsorted(self.time, [start, end])
        good = ~self.spoiled[first:last]
        noise = noise_of(self.force[first:last][good], self.step)
        if noise is None:
            raise Unusable("no_noise")
        return noise

    def mean(self, start: float, end: float, noise: Noise) -> Estimate:
        """Mean force [N] of a window, with the noise's share of its uncertainty."""
        window = self.window(start, end)
        count = window.stop - window.start
        block = min(count, max(4, round(BEFORE_ON / self.step)))
        sd = noise.sd(np.full(block, 1.0 / block)) * np.sqrt(block / count)
        return Estimate(float(np.mean(self.force[window])), sd)

    @cached_property
    def force_before_on(self) -> Estimate:
        """Force just before the voltage [N]: mean over one period of the stage's steps."""
        on = self.events.on
        return self.mean(on - BEFORE_ON, on, self.noise_moving)

    @cached_property
    def switch_off_level(self) -> Estimate:
        """Median force of the last 3 ms before the voltage falls [N]."""
        off = self.events.off
        window = self.window(off - 0.003, off, least=10)
        force = self.force[window]
        noise = self.noise_moving
        drawn = np.median(noise.windows(len(force), 160), axis=1)
        return Estimate(float(np.median(force)), float(np.sqrt(np.mean(drawn**2))))

    @cached_property
    def final_level(self) -> Estimate:
        """Mean force 10 to 110 ms after the voltage fell [N]."""
        off = self.events.off
        return self.mean(off + 0.010, off + 0.110, self.noise_rest)
