"""One simulated run: the model's history as the rig would have logged it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.model import ClutchModel
from eaclutch.records import FloatArray, Recording, RunConditions, RunSettings
from eaclutch.simulation.drive_signal import clock, half_wave, sensed_voltage
from eaclutch.simulation.noise import BenchNoise, disturb
from eaclutch.simulation.plan import RecordTiming

SLIPS = 400  # static capacities drawn for a run; the last is kept for what comes later


def scatter_factors(noise: BenchNoise, rng: np.random.Generator, runs: int) -> tuple[FloatArray, FloatArray]:
    """Factors of static and of kinetic friction from run to run, (runs,) each."""
    static = np.exp(noise.capacity_scatter_run * rng.standard_normal(runs))
    return static, np.exp(noise.kinetic_scatter_run * rng.standard_normal(runs))


def scattered(
    parameters: Mapping[str, float], noise: BenchNoise, rng: np.random.Generator
) -> dict[str, float]:
    """Parameters of one run: the campaign's, with friction that scatters from run to run."""
    static, kinetic = (float(factor[0]) for factor in scatter_factors(noise, rng, 1))
    factors = {"film_static": static, "base_static": static, "film_kinetic": kinetic, "base_kinetic": kinetic}
    return {name: value * factors.get(name, 1.0) for name, value in parameters.items()}


def record_run(
    model: ClutchModel,
    conditions: RunConditions,
    index: int,
    parameters: Mapping[str, float],
    settings: RunSettings,
    timing: RecordTiming,
    zero: float,
    noise: BenchNoise,
    rng: np.random.Generator,
) -> Recording:
    """Run ``index`` of ``conditions`` as logged: the four columns, each (samples,).

    parameters: the campaign's values by name (every calibrated parameter and those of the effects that are on);
    zero [N] of this run's force. The substrate is met by the stage some tenths of a second after the start.
    """
    drive_time = timing.travel / settings.speed
    time = clock(timing.before + drive_time + timing.after, timing.sample_interval, rng)
    on = timing.before + rng.uniform(0.0, timing.sample_interval)
    stop = on + drive_time
    off = stop + half_wave(settings.frequency)
    factors = np.exp(noise.capacity_scatter_slip * rng.standard_normal(SLIPS))
    force = model.history(
        conditions, index, scattered(parameters, noise, rng), time - on, capacity_factors=factors
    )
    force = _before_contact(force, time, parameters["stiffness"] * settings.speed, timing, rng)
    voltage = sensed_voltage(
        time, on, off, settings.voltage, settings.frequency, model.bench.drive, noise, rng
    )
    moving = (time < stop).astype(float)
    logged = disturb(force, time, moving, voltage, settings.voltage, zero, noise, rng)
    flag = ((time >= on) & (time < off)).astype(float)
    return Recording(settings, time, logged, flag, voltage)


def _before_contact(
    force: FloatArray, time: FloatArray, ramp_rate: float, timing: RecordTiming, rng: np.random.Generator
) -> FloatArray:
    """No force until the stage meets the substrate, then it climbs at ``ramp_rate`` [N/s] to the sliding one."""
    met = min(rng.uniform(*timing.contact), 0.3 * timing.before)
    climbing = np.maximum(time - met, 0.0) * ramp_rate
    return np.where(time < timing.before, np.minimum(force, climbing), force)
