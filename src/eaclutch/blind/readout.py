"""What the amplifier makes of the force: gain, low pass, drift, zero, mains, lines, pick-up, white noise.

Magnitudes measured on the published logs (docs/measurements/blind_noise.json, ``eaclutch blind noise``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from eaclutch.blind.world import Runs
from eaclutch.records import FloatArray

SAMPLE_STEP = 78.125e-6  # s
WHITE_SD = 0.011  # N
PICK_UP = 0.14e-3  # N/V, in the three samples after the rise
ADC_STEP = 5.08e-5  # N


@dataclass(frozen=True)
class Disturbance:
    """Noise of one session: mains by harmonic [N], lines while the stage moves [Hz], [N], zero [N]."""

    zero: float
    mains: FloatArray
    line_frequency: FloatArray
    line_amplitude: FloatArray
    white_sd: float


def draw_disturbances(sessions: int, rng: np.random.Generator) -> tuple[Disturbance, ...]:
    """One a session; mains is strong in one session out of three, zeros lie tens of mN apart."""
    loud = rng.integers(0, sessions)
    return tuple(
        Disturbance(
            zero=float(rng.normal(0, 0.015)),
            mains=np.array([0.008, 0.0025, 0.002]) * (rng.uniform(0.7, 1.2) if s == loud else 0.08),
            line_frequency=rng.uniform([195, 298, 310, 396, 590], [203, 303, 318, 404, 604]),
            line_amplitude=rng.uniform(0.4e-3, 1.2e-3, 5),
            white_sd=float(WHITE_SD * rng.uniform(0.96, 1.05)),
        )
        for s in range(sessions)
    )


def readout(
    force: FloatArray,
    time: FloatArray,
    on: float,
    off: float,
    moving: float,
    runs: Runs,
    i: int,
    disturbance: Disturbance,
    rng: np.random.Generator,
) -> FloatArray:
    """Force as logged [N] (samples,) from the true one; ``moving``: instant at which the stage stops."""
    lag = float(runs.knob("readout_time")[i])
    if lag > 0:
        keep = np.exp(-SAMPLE_STEP / lag)
        force = lfilter([1 - keep], [1, -keep], force, zi=[keep * force[0]])[0]
    force = force * runs.knob("reading_gain", 1.0)[i] + disturbance.zero
    force = force + runs.knob("zero_drift")[i] * np.clip(time - on, 0, None)
    phase = rng.uniform(0, 2 * np.pi, len(disturbance.mains))
    for harmonic, amplitude in enumerate(disturbance.mains, start=1):
        force = force + amplitude * np.sin(2 * np.pi * 50 * harmonic * time + phase[harmonic - 1])
    going = time < moving
    for frequency, amplitude in zip(disturbance.line_frequency, disturbance.line_amplitude, strict=True):
        hum = amplitude * np.sin(2 * np.pi * frequency * time[going] + rng.uniform(0, 2 * np.pi))
        force[going] = force[going] + hum
    after = np.searchsorted(time, on)
    force[after : after + 3] += (
        PICK_UP * runs.voltage[i] * np.array([0.6, 1.0, 0.5])[: len(force[after : after + 3])]
    )
    force = force + disturbance.white_sd * rng.standard_normal(len(force))
    return np.round(force / ADC_STEP) * ADC_STEP
