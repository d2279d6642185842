"""Effects that the library does not have: the right answer is ``unknown``.

Same shape as the named ones. Where an effect acts on the reading instead of the clutch, it turns a knob
that ``readout`` or the bench readings look at.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from eaclutch.blind.candidates import Law
from eaclutch.blind.world import Constants, Runs


def leakage_attraction(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """Johnsen-Rahbek: charge creeps to the summits while the polarity holds (DOI 10.1002/adma.202101849)."""
    half_period = np.where(runs.frequency > 0.5, 0.5 / runs.frequency, runs.drive_time)
    gain = 0.25 * size * -np.expm1(-half_period / 0.08)
    return runs.turn(force_factor=runs.knob("force_factor", 1.0) * (1 + gain)), c


def broken_electrodes(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """Fingers burnt off at the rim: wide strips lose more of their area."""
    lost = 0.32 * size * np.clip((runs.width - 2e-3) / 4e-3, 0, 1) ** 0.8
    return runs.turn(area_factor=np.maximum(1 - lost, 0.1)), c


def wrong_gain(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """The load cell reads too much in one session (a calibration that was not repeated)."""
    chosen = runs.session == rng.integers(0, 3)
    return runs.turn(reading_gain=1 + 0.25 * size * chosen), c


def slow_stage(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Lost steps: the stage moves slower than it is told, the more the harder it pushes."""
    return runs.turn(speed_factor=np.maximum(1 - 0.25 * size, 0.2)), c


def film_creep(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """The film thins for good under repeated load, from run to run over the whole campaign."""
    age = np.arange(len(runs)) / len(runs)
    return replace(
        runs, film_thickness=runs.film_thickness * np.maximum(1 - 0.07 * size * np.sqrt(age), 0.3)
    ), c


def zero_wander(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """The amplifier warms up while the drive is on: its zero drifts within the run."""
    return runs.turn(zero_drift=0.015 * size * (runs.voltage / 300)), c


def supply_droop(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """The supply cannot hold its voltage at kHz drive: it gives way abruptly above a corner."""
    droop = 0.3 * size * (runs.frequency / 5000) ** 2 / (1 + (runs.frequency / 5000) ** 2)
    return runs.turn(force_factor=runs.knob("force_factor", 1.0) * np.maximum(1 - droop, 0.05) ** 2), c


def sluggish_readout(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """A low pass in the amplifier, after the load cell."""
    return runs.turn(readout_time=2.0e-4 * size), c


def bent_substrate(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Thin, wide strips bow: a part of the pad does not face them at all, preload flattens it."""
    slender = (runs.width / 2e-3) / (runs.thickness / 2e-3)
    bow = 0.35 * size * np.clip(slender - 1, 0, None) / (1 + runs.preload / 0.4)
    return runs.turn(area_factor=np.maximum(1 - bow, 0.1), contact_factor=np.maximum(1 - 0.5 * bow, 0.3)), c


def polishing(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Sliding polishes the film: its friction falls within a session and recovers until the next."""
    worn = 1 - np.minimum(0.3 * size, 0.9) * -np.expm1(-runs.order / 8)
    return replace(runs, film_static=runs.film_static * worn, film_kinetic=runs.film_kinetic * worn), c


def dust(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Grains under the film in the later runs of each session hold it up."""
    dirty = runs.order > np.median(runs.order)
    return runs.turn(dust_stiffness=1.5e8 * size * dirty * runs.width / 2e-3, dust_height=8e-6), c


def backlash(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Play in the drive train: the ramp starts late, by a distance that differs from run to run."""
    return runs.turn(backlash=1.2e-6 * size * rng.uniform(0.7, 1.3, len(runs))), c


def swollen_film(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Humidity softens the release only: viscous suction grows with preload, friction stays."""
    return runs.turn(
        squeeze_factor=runs.knob("squeeze_factor", 1.0) * (1 + 4.0 * size * (runs.preload / 0.5) ** 0.5)
    ), c


def drifting_gain(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """The load cell's gain creeps up from the first run of the campaign to the last."""
    age = np.arange(len(runs)) / len(runs)
    return runs.turn(reading_gain=1 + 0.2 * size * age), c


def warm_film(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """The film warms up over a session and its permittivity falls, until the next one begins cold."""
    return replace(runs, kappa=runs.kappa * np.maximum(1 + 0.1 * size * np.expm1(-runs.order / 6), 0.2)), c


def humid_day(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """What lies between film and strip is thicker in one session: parting takes longer, force and friction stay."""
    chosen = runs.session == rng.integers(0, 3)
    return runs.turn(squeeze_factor=runs.knob("squeeze_factor", 1.0) * (1 + 1.5 * size * chosen)), c


def leaky_film(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """The film conducts: while a polarity lasts its own field runs down, and with it the force at low frequency."""
    half_period = np.where(runs.frequency > 0.5, 0.5 / runs.frequency, runs.drive_time)
    kept = 1 + 0.25 * min(size, 3.0) * np.expm1(-half_period / 0.03)
    return runs.turn(force_factor=runs.knob("force_factor", 1.0) * kept), c


UNNAMED: dict[str, Law] = {
    law.__name__: law
    for law in (
        leakage_attraction,
        broken_electrodes,
        wrong_gain,
        slow_stage,
        film_creep,
        zero_wander,
        supply_droop,
        sluggish_readout,
        bent_substrate,
        polishing,
        dust,
        backlash,
        swollen_film,
        drifting_gain,
        warm_film,
        humid_day,
        leaky_film,
    )
}
