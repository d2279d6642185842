"""A bench without physics, to try the link alone: columns of the right shape, each run another."""

from __future__ import annotations

from datetime import datetime

import numpy as np

from eaclutch.records import Recording, RunSettings
from eaclutch.rig.link.protocol import BenchSetting, Command, Timing

SHORT = Timing(before=0.02, after=0.02)  # for trials in which only the link matters


class SyntheticBench:
    """Runs with one pulse of flag and voltage, a force ramp and white noise; a source for the emulated rig."""

    def __init__(self, rng: np.random.Generator, timing: Timing):
        self.rng, self.timing = rng, timing

    def __call__(self, setting: BenchSetting, command: Command) -> Recording:
        """The recording of one more run, (samples,) columns."""
        n = command.samples(self.timing) + int(self.rng.integers(-3, 4))
        period = self.timing.sample_period * 1e6
        time = 857e-6 + np.cumsum(np.round(period + self.rng.normal(0, 0.4, n))) * 1e-6
        since_on = time - time[0] - self.timing.before
        driven = (since_on > 0) & (time < time[-1] - self.timing.after)
        dc = setting.frequency <= 0.1
        high = driven & (dc | (np.floor(since_on * setting.frequency * 2) % 2 == 0))
        force = self.rng.normal(0.02, 0.011, n) + driven * np.linspace(0.0, 1.0, n)
        settings = RunSettings(
            "", datetime(2000, 1, 1), command.travel, command.speed, setting.preload, setting.voltage,
            setting.frequency, setting.width, setting.substrate,
        )  # fmt: skip
        return Recording(settings, time, force, driven.astype(float), high * setting.voltage + 0.344)
