"""What the bench adds to a force: white noise, mains, vibration lines, electrical pick-up, a zero, counts.

The default figures follow the published recordings (`eaclutch bench-noise`, `docs/simulation.md`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eaclutch.records import FloatArray


@dataclass(frozen=True)
class Line:
    """A vibration line: frequency [Hz], median amplitude [N], and whether only the moving stage excites it."""

    frequency: float
    amplitude: float
    moving_only: bool = True


# Multiples of the stepper's 50 full steps per second at 0.5 mm/s, and two lines that never rest.
LINES = (
    Line(200.0, 0.7e-3), Line(300.0, 0.9e-3), Line(350.0, 0.6e-3), Line(400.0, 0.6e-3),
    Line(450.0, 0.7e-3), Line(500.0, 0.5e-3), Line(550.0, 0.6e-3),
    Line(314.0, 1.3e-3, moving_only=False), Line(78.0, 0.8e-3, moving_only=False),
)  # fmt: skip


@dataclass(frozen=True)
class BenchNoise:
    """Noise of the bench; SI units. ``*_scatter`` are relative (sd of a logarithm), drawn per run or per slip."""

    white: float = 0.0114
    mains_amplitude: float = 0.9e-3
    mains_scatter: float = 0.9
    lines: tuple[Line, ...] = LINES
    line_scatter: float = 0.35
    pickup: float = 0.14e-3  # N/V in the first sample after the voltage rises
    pickup_decay: tuple[float, ...] = (1.0, 0.5, 0.22)
    pickup_rising: float = -0.04e-3  # N/V at later rising polarity edges of the sensed electrode
    pickup_falling: float = 0.023e-3  # N/V at its falling edges
    pickup_lag: int = 2  # samples from the logged edge to its pick-up
    zero_common: float = 0.01  # N, about which the sessions' zeros lie
    zero_session: float = 0.02  # N, sd of the sessions' zeros about a common one
    zero_run: float = 0.008  # N, sd of a run's zero within its session
    force_count: float = 5.07e-5  # N a count
    voltage_count: float = 0.344  # V a count
    voltage_white: float = 0.4  # V
    voltage_offset: float = 1.9  # V read at ground
    capacity_scatter_slip: float = 0.03
    capacity_scatter_run: float = 0.08
    kinetic_scatter_run: float = 0.04
    preload_scatter_run: float = 0.25

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            scalar = isinstance(value, (int, float))
            if scalar and not name.startswith("pickup") and not (np.isfinite(value) and value >= 0):
                raise ValueError(f"{name} is {value}, it must be a number >= 0")


QUIET = BenchNoise(
    white=0.0, mains_amplitude=0.0, lines=(), pickup=0.0, pickup_rising=0.0, pickup_falling=0.0, zero_session=0.0,
    zero_run=0.0, force_count=0.0, voltage_white=0.0, capacity_scatter_slip=0.0, capacity_scatter_run=0.0,
    kinetic_scatter_run=0.0, preload_scatter_run=0.0,
)  # fmt: skip
"""A bench without noise (the voltage keeps its counts)."""


def disturb(
    force: FloatArray,
    time: FloatArray,
    moving: FloatArray,
    voltage: FloatArray,
    drive_voltage: float,
    zero: float,
    noise: BenchNoise,
    rng: np.random.Generator,
) -> FloatArray:
    """A clean force as the load cell's electronics log it.

    force [N], time [s], moving (1 while the stage moves), voltage [V] as sensed: each (samples,);
    drive_voltage [V]; zero [N] of this run. Returns the logged force (samples,) [N].
    """
    logged = force + zero + noise.white * rng.standard_normal(len(force))
    mains = noise.mains_amplitude * np.exp(noise.mains_scatter * rng.standard_normal())
    logged = logged + mains * np.sin(2 * np.pi * 50.0 * time + rng.uniform(0, 2 * np.pi))
    for line in noise.lines:
        amplitude = line.amplitude * np.exp(noise.line_scatter * rng.standard_normal())
        frequency = line.frequency * (1.0 + 5e-4 * rng.standard_normal())
        swing = amplitude * np.sin(2 * np.pi * frequency * time + rng.uniform(0, 2 * np.pi))
        logged = logged + (swing * moving if line.moving_only else swing)
    logged = logged + _pickup(voltage, drive_voltage, noise)
    return counts(logged, noise.force_count)


def counts(values: FloatArray, count: float) -> FloatArray:
    """``values`` rounded to whole counts (unchanged where a count is 0)."""
    return values if count == 0 else np.round(values / count) * count


def _pickup(voltage: FloatArray, drive_voltage: float, noise: BenchNoise) -> FloatArray:
    """Spikes [N] after the edges of the sensed voltage, (samples,)."""
    spikes = np.zeros(len(voltage) + 64)
    edges = np.diff((voltage > 0.5 * drive_voltage).astype(int))
    rising, falling = np.flatnonzero(edges > 0) + 1, np.flatnonzero(edges < 0) + 1
    if drive_voltage == 0 or len(rising) == 0:
        return spikes[: len(voltage)]
    for step, share in enumerate(noise.pickup_decay):
        at = noise.pickup_lag + step
        spikes[rising[:1] + at] += noise.pickup * drive_voltage * share
        spikes[rising[1:] + at] += noise.pickup_rising * drive_voltage * share
        spikes[falling + at] += noise.pickup_falling * drive_voltage * share
    return spikes[: len(voltage)]
