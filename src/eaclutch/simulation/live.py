"""The simulated rig, one run at a time: what a capture finds at the other end of the line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime

import numpy as np

from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, Recording
from eaclutch.rig.link.protocol import BenchSetting, Command, Timing
from eaclutch.simulation.campaign import conditions_of, settings_of, values_of
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.plan import Plan, PlannedRun, RecordTiming
from eaclutch.simulation.run import record_run

LIGHT_PRELOAD = 0.1  # N, what film and wires weigh on the substrate where no weight is set


class LiveBench:
    """A bench that is asked for runs: one session, one zero, runs counted in the order they are asked for.

    parameters: values by name that depart from the model's defaults (SI); effects: those switched on.
    """

    def __init__(
        self,
        bench: Bench,
        effects: Sequence[str],
        parameters: Mapping[str, float],
        timing: Timing,
        rng: np.random.Generator,
        noise: BenchNoise | None = None,
    ):
        self.noise = BenchNoise() if noise is None else noise
        self.bench, self.timing, self.rng = bench, timing, rng
        self.model = ClutchModel(bench, tuple(effects))
        self.values = values_of(self.model, parameters)
        self.zero = self.noise.zero_common + self.noise.zero_session * rng.standard_normal()
        self.runs = 0

    def __call__(self, setting: BenchSetting, command: Command) -> Recording:
        """The recording of one more run, (samples,) columns. Raises InputError for a substrate the bench lacks."""
        recording = self.record(setting, command, self.runs, self.rng)
        self.runs += 1
        return recording

    def record(
        self, setting: BenchSetting, command: Command, run_order: int, rng: np.random.Generator
    ) -> Recording:
        """The recording of the run that is number ``run_order`` of the session, with its own generator."""
        bench = replace(self.bench, stage_speed=command.speed)
        preload = LIGHT_PRELOAD if setting.preload is None else setting.preload
        planned = PlannedRun(
            datetime(2000, 1, 1),
            setting.voltage,
            setting.frequency,
            setting.width,
            preload,
            setting.substrate,
        )
        timing = RecordTiming(
            self.timing.before, command.travel, self.timing.after, self.timing.sample_period
        )
        factor = np.exp(self.noise.preload_scatter_run * rng.standard_normal(1))
        conditions = conditions_of(Plan((planned,), timing), bench, self.values, factor)
        conditions = replace(conditions, run_order=np.array([float(run_order)]))
        zero = self.zero + self.noise.zero_run * rng.standard_normal()
        settings = settings_of(planned, timing, bench)
        return record_run(self.model, conditions, 0, self.values, settings, timing, zero, self.noise, rng)
