"""Simulated recordings of the other benches: capacitance against force, permittivity, load-cell bursts."""

from __future__ import annotations

import lzma
from collections.abc import Mapping
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd

from eaclutch.files import atomic, write_csv
from eaclutch.physics.model import ClutchModel
from eaclutch.records import CapacitanceReadings, Spectrum
from eaclutch.simulation.drive_signal import clock
from eaclutch.simulation.noise import BenchNoise, counts
from eaclutch.simulation.plan import SideBenches

TRIAL_SCATTER = 0.06  # sd of the log of the contact stiffness from trial to trial
READING_NOISE = 0.15e-12  # F
SOURCE_SCATTER = 0.03  # sd of the log of a source's permittivity
POINT_SCATTER = 0.01  # sd of the log of a point of a spectrum
READINGS_FILE = "readings.csv"
BURSTS = 10
BURST_FORCE = 0.07  # N
BURST_PAUSE = 0.5  # s
STAGE_SPEEDS = (6.0, 8.0, 10.0)  # mm/s


def capacitance_readings(
    model: ClutchModel, parameters: Mapping[str, float], side: SideBenches, rng: np.random.Generator
) -> CapacitanceReadings:
    """Readings of the capacitance bench as its file would give them; the contact stiffness scatters by trial."""
    columns: list[tuple[float, float, float, str]] = []
    for width in side.capacitance_widths:
        for trial in range(1, side.capacitance_trials + 1):
            scatter = np.exp(TRIAL_SCATTER * rng.standard_normal())
            own = {**parameters, "contact_stiffness": parameters["contact_stiffness"] * scatter}
            force = np.sort(rng.uniform(*side.capacitance_force, side.capacitance_readings))
            farad = model.capacitance(force, np.full(len(force), width), own)[0]
            farad = farad + READING_NOISE * rng.standard_normal(len(force))
            columns += [
                (round(f, 4), round(c * 1e12, 3) * 1e-12, width, f"w{width * 1e3:g}_{trial}")
                for f, c in zip(force.tolist(), farad.tolist(), strict=True)
            ]
    return CapacitanceReadings(
        force=np.array([row[0] for row in columns]),
        capacitance=np.array([row[1] for row in columns]),
        width=np.array([row[2] for row in columns]),
        trial=tuple(f"{READINGS_FILE}/{row[3]}" for row in columns),
        source=(READINGS_FILE,) * len(columns),
    )


def write_capacitance(folder: Path, readings: CapacitanceReadings) -> None:
    """``capacitance/readings.csv``: force_n, capacitance_pf, width_mm, trial."""
    if len(readings.force):
        table = pd.DataFrame(
            {
                "force_n": readings.force,
                "capacitance_pf": np.round(readings.capacitance * 1e12, 3),
                "width_mm": np.round(readings.width * 1e3, 3),
                "trial": [label.split("/")[1] for label in readings.trial],
            }
        )
        write_csv(folder / "capacitance" / READINGS_FILE, table)


def spectra(
    model: ClutchModel, parameters: Mapping[str, float], side: SideBenches, rng: np.random.Generator
) -> tuple[Spectrum, ...]:
    """Spectra of the film from several sources, each with a scale error of its own."""
    found = []
    for source in range(1, side.permittivity_sources + 1):
        frequency = np.geomspace(*side.permittivity_frequency, side.permittivity_points)
        kappa = model.permittivity(frequency, parameters)[0]
        scatter = SOURCE_SCATTER * rng.standard_normal() + POINT_SCATTER * rng.standard_normal(len(frequency))
        found.append(Spectrum(f"source_{source}", frequency, kappa * np.exp(scatter)))
    return tuple(found)


def write_permittivity(folder: Path, measured: tuple[Spectrum, ...]) -> None:
    """``permittivity/<source>.csv``: frequency_hz, relative_permittivity."""
    for spectrum in measured:
        table = pd.DataFrame(
            {"frequency_hz": spectrum.frequency, "relative_permittivity": spectrum.permittivity}
        )
        write_csv(folder / "permittivity" / f"{spectrum.source}.csv", table)


def write_load_cell(
    folder: Path,
    parameters: Mapping[str, float],
    side: SideBenches,
    first: datetime,
    noise: BenchNoise,
    rng: np.random.Generator,
) -> None:
    """``load_cell/<stamp>_calibrate_loadcell_damper_dx=<mm>_speed=<mm/s>mms.csv.xz``: the bare cell, shaken."""
    for number in range(side.load_cell_logs):
        speed = STAGE_SPEEDS[number % len(STAGE_SPEEDS)]
        stamp = (first - timedelta(minutes=10 * (side.load_cell_logs - number))).strftime("%Y%m%d_%H_%M_%S")
        move = 0.1 / speed
        time, force, forward = bursts(parameters, move, noise, rng)
        lines = ["Time,Load Cell,Moving Forward"]
        lines += [
            f"{t!r},{round(f, 8)!r},{d!r}"
            for t, f, d in zip(np.round(time * 1e6).tolist(), force.tolist(), forward.tolist(), strict=True)
        ]
        name = f"{stamp}_calibrate_loadcell_damper_dx=0.1_speed={speed:g}mms.csv.xz"
        with atomic(folder / "load_cell" / name) as temporary:
            temporary.write_bytes(lzma.compress(("\n".join(lines) + "\n").encode(), preset=1))


def bursts(
    parameters: Mapping[str, float], move: float, noise: BenchNoise, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], force [N], direction (1 forward), each (samples,): ten starts and stops of the bare stage.

    ``move`` [s] is how long the stage moves each time; a stop rings twice as much as a start.
    """
    k, m, b = (parameters[name] for name in ("stiffness", "mass", "damping"))
    decay, swing = b / (2 * m), np.sqrt(k / m - (b / (2 * m)) ** 2)
    period = move + BURST_PAUSE
    time = clock(BURSTS * period, 78.125e-6, rng)
    force = noise.white * rng.standard_normal(len(time))
    forward = np.zeros(len(time))
    for number in range(BURSTS):
        sign = 1.0 if number % 2 == 0 else -1.0
        forward[(time >= number * period) & (time < (number + 1) * period)] = float(number % 2 == 0)
        for start, share in ((number * period, 0.5), (number * period + move, -1.0)):
            since = np.maximum(time - start, 0.0)
            amplitude = BURST_FORCE * rng.uniform(0.85, 1.1) * share * sign
            ring = amplitude * np.exp(-decay * since) * np.sin(swing * since)
            force += ring
    return time, counts(force, noise.force_count), forward
