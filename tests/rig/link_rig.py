"""A source of recordings for the emulated rig: no physics, but the columns' shapes and converters."""

from datetime import datetime

import numpy as np

from eaclutch.records import Recording, RunSettings
from eaclutch.rig.link.emulator import BenchSetting
from eaclutch.rig.link.protocol import Command, Timing

SHORT = Timing(before=0.02, after=0.02)


class SyntheticSource:
    """Runs with a pulse of flag and voltage, a force ramp and noise, each another."""

    def __init__(self, rng: np.random.Generator, timing: Timing = SHORT):
        self.rng, self.timing = rng, timing

    def __call__(self, setting: BenchSetting, command: Command) -> Recording:
        n = command.samples(self.timing) + int(self.rng.integers(-3, 4))
        time = (
            857e-6 + np.cumsum(np.round(self.timing.sample_period * 1e6 + self.rng.normal(0, 0.4, n))) * 1e-6
        )
        driven = (time > time[0] + self.timing.before) & (time < time[-1] - self.timing.after)
        half_waves = np.floor((time - time[0] - self.timing.before) * setting.frequency * 2)
        high = driven & ((half_waves % 2 == 0) | (setting.frequency <= 0.1))
        force = self.rng.normal(0.02, 0.011, n) + driven * np.linspace(0.0, 1.0, n)
        settings = RunSettings(
            "20240101_00_00_00_x", datetime(2024, 1, 1), command.travel, command.speed, setting.preload,
            setting.voltage, setting.frequency, setting.width, setting.substrate,
        )  # fmt: skip
        return Recording(settings, time, force, driven.astype(float), high * setting.voltage + 0.344)
