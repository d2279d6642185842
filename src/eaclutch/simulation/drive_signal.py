"""The clock, the enable flag and the sensed voltage of a simulated run."""

from __future__ import annotations

import numpy as np

from eaclutch.records import DC_LABEL, Drive, FloatArray
from eaclutch.simulation.noise import BenchNoise, counts


def clock(duration: float, interval: float, rng: np.random.Generator) -> FloatArray:
    """Time stamps [s] in whole microseconds, (samples,): the first after about 0.9 ms, then one an ``interval``."""
    first = rng.uniform(0.8e-3, 1.1e-3)
    ticks = first + interval * np.arange(int((duration - first) / interval) + 1)
    return np.floor(ticks * 1e6) * 1e-6


def half_wave(frequency: float) -> float:
    """How long the driver goes on after its enable line falls, to finish its half wave [s]; 0 for DC."""
    return 0.0 if frequency <= DC_LABEL else 0.5 / frequency


def sensed_voltage(
    time: FloatArray,
    on: float,
    off: float,
    voltage: float,
    frequency: float,
    drive: Drive,
    noise: BenchNoise,
    rng: np.random.Generator,
) -> FloatArray:
    """Voltage [V] of the one electrode that is read, (samples,): high in every second half wave of the drive.

    ``time`` [s]; the voltage is there from ``on`` to ``off`` [s]. Which electrode goes first is chance.
    """
    rise, fall = drive.rise_10_90 / np.log(9.0), drive.fall_90_10 / np.log(9.0)
    if frequency <= DC_LABEL:
        half, grounded_first = np.inf, 0
    else:
        half, grounded_first = 0.5 / frequency, int(rng.integers(2))
    since = np.clip(time, on, off) - on
    number = np.floor(since / half) if np.isfinite(half) else np.zeros(len(time))
    high = (number + grounded_first) % 2 == 0
    into = since - number * half if np.isfinite(half) else since
    first = number == 0
    level = np.where(high, 1.0 - np.exp(-into / rise), np.where(first, 0.0, np.exp(-into / fall)))
    level = np.where(time < on, 0.0, level)
    at_off = (np.ceil((off - on) / half - 1e-9) - 1 + grounded_first) % 2 == 0 if np.isfinite(half) else True
    level = np.where(time >= off, np.exp(-np.maximum(time - off, 0.0) / fall) if at_off else 0.0, level)
    reading = noise.voltage_offset + level * voltage + noise.voltage_white * rng.standard_normal(len(time))
    return counts(np.maximum(reading, 0.0), noise.voltage_count)
