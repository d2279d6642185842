"""Runs made from closed formulas, so that every event and level is known: for tests of reading and extraction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from eaclutch.records import Recording, RunSettings
from eaclutch.rig.log_names import log_name

STEP = 78.125e-6


@dataclass(frozen=True)
class Made:
    """What a made run is to show. SI units; times count from voltage on or off."""

    voltage: float = 300.0
    frequency: float = 1000.0
    friction: float = 0.12
    onset: float = 0.2e-3
    ramp: float = 6.0
    capacity: float = 0.6  # above the friction, where the ramp ends
    hold: float = 0.55  # above the friction, in the end
    final: float = 0.10
    delay: float = 0.3e-3  # until the force begins to fall
    fall: float = 0.7e-3  # half a period of the fall
    swing: float = 0.0  # amplitude of a free swing after release
    zero: float = 0.0
    contact: float = 0.0  # s at which the tip meets the substrate
    white: float = 0.011
    mains: float = 0.001
    pick_up: float = 0.14e-3  # N/V
    grounded_first: bool = False
    after: float = 2.0
    travel: float = 1.5e-3
    before: float = 2.0  # s until the voltage


def settings_of(
    made: Made, stamp: datetime = datetime(2024, 11, 3, 15, 0, 0), width: float = 2e-3
) -> RunSettings:
    """Settings that name the run's log."""
    blank = RunSettings("", stamp, made.travel, 0.5e-3, None, made.voltage, made.frequency, width, "brass")
    return replace(blank, run=log_name(blank))


def make_run(made: Made, rng: np.random.Generator) -> tuple[Recording, float, float]:
    """A recording, and the true instants of voltage on and off [s] in its own time."""
    on = made.before + rng.uniform(0, STEP)
    dc = made.frequency <= 0.1
    half = np.inf if dc else 0.5 / made.frequency
    driven = made.travel / 0.5e-3
    off = on + (driven if dc else np.ceil(driven / half - 1e-9) * half)
    time = np.floor((0.9e-3 + STEP * np.arange(int((off + made.after) / STEP))) * 1e6) * 1e-6
    force = clean_force(made, time, on, off)
    force = np.where(
        time < made.contact,
        0.0,
        np.minimum(force, np.maximum(time - made.contact, 0) * 9 + (made.contact == 0) * 9),
    )
    force += made.zero + made.white * rng.standard_normal(len(time))
    force += made.mains * np.sin(2 * np.pi * 50 * time + rng.uniform(0, 2 * np.pi))
    force += 0.0015 * np.sin(2 * np.pi * 314 * time + rng.uniform(0, 2 * np.pi))
    for edge, sign in ((on, 1.0), (off, -1.0)):
        first = int(np.searchsorted(time, edge)) + 2
        force[first : first + 3] += sign * made.pick_up * made.voltage * np.array([1.0, 0.5, 0.2])
    high = (time >= on) & (time < off)
    if not dc:
        high &= (np.floor((time - on) / half).astype(int) + made.grounded_first) % 2 == 0
    voltage = 1.72 + 0.344 * rng.integers(0, 3, len(time)) + made.voltage * high
    flag = ((time >= on) & (time < off)).astype(float)
    return Recording(settings_of(made), time, force, flag, voltage), on, off


def clean_force(made: Made, time: np.ndarray, on: float, off: float) -> np.ndarray:
    """The force [N] without zero and noise: friction, ramp to the capacity, sag to the hold, fall to the end."""
    since, after = time - on, time - off
    climb = np.minimum(np.maximum(since - made.onset, 0.0) * made.ramp, made.capacity)
    top = made.onset + made.capacity / made.ramp
    sag = (made.capacity - made.hold) * (1.0 - np.exp(-np.maximum(since - top, 0.0) / 0.3))
    held = made.friction + climb - sag
    level = made.friction + made.hold
    phase = np.clip((after - made.delay) / made.fall, 0.0, 1.0) * np.pi
    falling = made.final + (level - made.final) * 0.5 * (1.0 + np.cos(phase))
    rung = np.maximum(after - made.delay - made.fall, 0.0)
    w = 2 * np.pi * 640.0
    ring = -made.swing * np.exp(-0.02 * w * rung) * np.sin(w * rung)
    return np.where(after < 0, held, falling + ring)


def release_time(made: Made, share: float) -> float:
    """When the made force has done ``share`` of its way [s after voltage off]."""
    return made.delay + made.fall * float(np.arccos(1.0 - 2.0 * share)) / np.pi


def without_lines(column: np.ndarray, *holes: tuple[int, int]) -> np.ndarray:
    """A column (samples,) that lost ``count`` lines at each (sample, count): slid left, zeros at the end."""
    keep = np.ones(len(column), dtype=bool)
    for at, count in holes:
        keep[at : at + count] = False
    kept = column[keep]
    return np.concatenate([kept, np.zeros(len(column) - len(kept))])


def made(seed: int = 0, **changes):
    return make_run(Made(**changes), np.random.default_rng(seed))


def grounded_since(recording, on, frequency, seconds):
    """The recording with polarity edges so that the sensed electrode is grounded ``seconds`` before voltage off."""
    half = 0.5 / frequency
    driven = recording.flag > 0.5
    waves = np.floor((recording.time - on + seconds) / half).astype(int)
    return replace(recording, voltage=np.where(driven & (waves % 2 == 1), 300.0, 2.0))


def on_of(recording):
    """When the flag rises [s]."""
    return float(recording.time[recording.flag > 0.5][0]) - 0.5 * STEP
