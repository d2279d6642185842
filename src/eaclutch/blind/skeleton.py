"""Noise-free features of runs without the chance of stick-slip: what a case measures, said exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eaclutch.blind.clutch import Rest, at_rest
from eaclutch.blind.contact import contact_force
from eaclutch.blind.film import release_motion
from eaclutch.blind.loadtrain import (
    SWING_STEP,
    friction_forces,
    strengthened,
    swing,
    train_stiffness,
    weakened,
)
from eaclutch.blind.world import Constants, Runs
from eaclutch.records import FloatArray

# Feature: (phase, absolute sd, relative sd) of one run.
FEATURES = {
    "engagement_time_s": ("engage", 6e-4, 0.0),
    "ramp_rate_n_s": ("ramp", 0.2, 0.01),
    "shear_capacity_n": ("ramp", 4e-3, 0.04),
    "slip_fraction": ("hold", 0.04, 0.0),
    "hold_creep_n_s": ("hold", 4e-3, 0.0),
    "release_time_10_s": ("release", 5e-5, 0.05),
    "release_time_50_s": ("release", 3.5e-5, 0.05),
    "release_time_90_s": ("release", 4e-5, 0.05),
    "final_force_n": ("after", 0.04, 0.0),
}
STEPS = 1600  # of the swing: 6.4 ms


@dataclass(frozen=True)
class FilmPath:
    """What the film does, whatever rubs and swings behind it: at rest, and its contact force while released."""

    rest: Rest
    contact: FloatArray


def film_path(runs: Runs, c: Constants) -> FilmPath:
    """The film's part of ``skeleton``, the slow one."""
    rest = at_rest(runs, c)
    return FilmPath(
        rest, np.stack([contact_force(gap, runs, c) for gap in release_motion(rest.gap_on, runs, c)])
    )


def skeleton(runs: Runs, c: Constants, film: FilmPath | None = None) -> FloatArray:
    """Noise-free features (runs, features) without the chance of stick-slip: released from 85 % of capacity."""
    film = film_path(runs, c) if film is None else film
    off, on = (contact_force(gap, runs, c) for gap in (film.rest.gap_off, film.rest.gap_on))
    friction = friction_forces(on, off, runs, c)
    hold = friction.static_driven * strengthened(np.full(len(runs), 0.02), runs)
    stiffness, mass = train_stiffness(runs, c), c.mass + runs.knob("moving_mass")
    speed = np.maximum(hold - friction.kinetic_driven, 0) / np.sqrt(stiffness * mass)
    slide = friction.kinetic_driven * weakened(speed, runs)
    zeta = (c.damping + runs.knob("side_damping")) / (2 * np.sqrt(stiffness * mass))
    low = slide - np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)) * (hold - slide)
    gain, drift = runs.knob("reading_gain", 1.0), runs.knob("zero_drift")
    start = 0.85 * hold
    force = swing(film.contact, start, runs, c, STEPS)
    lag = runs.knob("readout_time")
    clock = SWING_STEP * np.arange(STEPS)
    final = force[-400:].mean(axis=0)
    times = []
    for share in (0.1, 0.5, 0.9):
        below = force < start + (final - start) * share
        first = np.argmax(below, axis=0)
        times.append(np.where(below.any(axis=0), clock[first] + lag, np.nan))
    columns = {
        "engagement_time_s": film.rest.onset,
        "ramp_rate_n_s": stiffness * c.stage_speed * runs.knob("speed_factor", 1.0) * gain,
        "shear_capacity_n": (hold - friction.kinetic_before) * gain,
        "slip_fraction": np.clip((hold - np.maximum(low, 0)) / hold, 0, 1),
        "hold_creep_n_s": drift,
        "release_time_10_s": times[0],
        "release_time_50_s": times[1],
        "release_time_90_s": times[2],
        "final_force_n": final * gain + drift * runs.drive_time,
    }
    return np.stack([columns[name] for name in FEATURES], axis=1)
