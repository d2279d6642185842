"""A case as the rig would have logged it: a whole campaign folder, serial faults included."""

from __future__ import annotations

import lzma
from datetime import timedelta
from pathlib import Path

import numpy as np

from eaclutch.blind.case import Case
from eaclutch.blind.clutch import VOLTAGE_ON, force_of
from eaclutch.blind.design import DC
from eaclutch.blind.generate import tables_of, write_bench
from eaclutch.blind.plan import generator
from eaclutch.blind.readout import SAMPLE_STEP, WHITE_SD, readout
from eaclutch.blind.world import Constants
from eaclutch.files import atomic
from eaclutch.records import FloatArray, Recording, RunSettings
from eaclutch.rig.logs import write_log

SENSED_SHARE = 0.983  # of the set voltage that the divider shows
VOLTAGE_STEP = 0.343994  # V a count
RESTING_COUNTS = 6  # of the divider without voltage
REST_AFTER = 2.0  # s
# Serial faults cluster: in one session 29 % of the runs lose force lines, two thirds of these voltage lines too.
GROUNDED_FIRST_SHARE = 0.08
OUTLIVED_SHARE = 0.2  # of the runs whose flag falls with the stage, before the voltage does
FAULT_SHARE, BOTH_SHARE, STRAY_SHARE = 0.29, 0.65, 0.01


def write_campaign(case: Case, folder: Path, *, text_every: int = 10) -> None:
    """Write the case in the contract's layout; every ``text_every``-th log as csv.xz, the others as npy."""
    write_bench(tables_of(case), folder)
    rng = generator(case.entry.namespace, case.entry.seed, "logs")
    bad_session = int(rng.integers(0, len(case.design.session_names)))
    for i, settings in enumerate(case.design.settings):
        recording = record(case, i, faulty=int(case.runs.session[i]) == bad_session, rng=rng)
        extension = ".csv.xz" if i % text_every == 0 else ".npy"
        write_log(recording, folder / "tensile" / f"{settings.run}{extension}")
    stamp = case.design.settings[0].stamp - timedelta(hours=1)
    name = f"{stamp:%Y%m%d_%H_%M_%S}_calibrate_loadcell_damper_dx=0.1_speed=6mms.csv.xz"
    write_bursts(case.constants, folder / "load_cell" / name, rng)


def record(case: Case, i: int, *, faulty: bool, rng: np.random.Generator) -> Recording:
    """Run ``i`` as logged: time in whole microseconds, force, flag, sensed voltage; faults where drawn."""
    runs, settings = case.runs, case.design.settings[i]
    on = VOLTAGE_ON + rng.uniform(0, SAMPLE_STEP)
    off = on + float(runs.drive_time[i])
    stop = off - float(runs.dwell[i])
    count = int((off + REST_AFTER) / SAMPLE_STEP) + int(rng.integers(-4, 5))
    time: FloatArray = 0.85e-3 + SAMPLE_STEP * np.arange(count, dtype=np.float64)
    force = force_of(case.motion, runs, i, time, on, float(case.free_start[i]))
    disturbance = case.disturbances[int(runs.session[i])]
    force = readout(force, time, on, off, stop, runs, i, disturbance, rng)
    grounded_first = settings.frequency > DC and bool(rng.random() < GROUNDED_FIRST_SHARE)
    outlived = not grounded_first and rng.random() < OUTLIVED_SHARE
    flag = ((time >= on - 1e-4) & (time < (stop if outlived else off))).astype(float)
    voltage = sensed_voltage(time - on, float(runs.drive_time[i]), settings, grounded_first, rng)
    columns = [np.floor(time * 1e6) * 1e-6, force, flag, voltage]
    if faulty and rng.random() < FAULT_SHARE:
        lost = int(np.clip(rng.lognormal(np.log(700), 1.0), 50, 9000))
        columns[1] = lose_lines(columns[1], lost, rng)
        if rng.random() < BOTH_SHARE:
            columns[3] = lose_lines(columns[3], max(50, int(lost * rng.uniform(0.3, 1.2))), rng)
    if rng.random() < STRAY_SHARE:
        columns[1] = columns[1].copy()
        columns[1][int(rng.integers(0, count))] = np.nan
    return Recording(settings, columns[0], columns[1], columns[2], columns[3])


def sensed_voltage(
    time: FloatArray,
    duration: float,
    settings: RunSettings,
    grounded_first: bool,
    rng: np.random.Generator,
) -> FloatArray:
    """Voltage of the one electrode that is sensed [V] (samples,); ``time`` counts from voltage on.

    A bipolar square wave shows as 0 / V; the sensed electrode may be the one at ground first.
    """
    driven = (time >= 0) & (time < duration)
    if settings.frequency > DC:
        half_wave = np.floor(np.clip(time, 0, None) * 2 * settings.frequency).astype(int)
        driven &= half_wave % 2 == int(grounded_first)
    amplitude = settings.voltage
    level = np.where(driven, SENSED_SHARE * amplitude, 0.0)
    counts = np.round(level / VOLTAGE_STEP) + RESTING_COUNTS + rng.integers(-1, 2, len(time))
    return counts * VOLTAGE_STEP


def lose_lines(column: FloatArray, lost: int, rng: np.random.Generator) -> FloatArray:
    """The column without ``lost`` lines at one place: the rest slides left and ends in exact zeros."""
    place = int(rng.integers(1000, len(column) - lost - 1000))
    kept = np.concatenate([column[:place], column[place + lost :]])
    return np.concatenate([kept, np.zeros(lost)])


def write_bursts(c: Constants, path: Path, rng: np.random.Generator) -> None:
    """A step-response log of the bare load cell: ten free swings of about 0.07 N in 65 000 rows."""
    count = 65000
    time = SAMPLE_STEP * np.arange(count)
    natural = np.sqrt(c.stiffness / c.mass)
    zeta = c.damping / (2 * np.sqrt(c.stiffness * c.mass))
    force = WHITE_SD * rng.standard_normal(count) + rng.normal(0, 0.02)
    for start in 0.25 + 0.47 * np.arange(10):
        late = np.maximum(time - start, 0)
        swing = np.exp(-zeta * natural * late) * np.sin(natural * np.sqrt(1 - zeta**2) * late)
        force += rng.uniform(0.15, 0.25) * np.where(time >= start, swing, 0)
    direction = (np.floor(time / 0.47) % 2).astype(int)
    lines = ["Time,Load Cell,Moving Forward"]
    lines += [
        f"{t:.1f},{f:.8f},{d}.0" for t, f, d in zip(np.round(time * 1e6), force, direction, strict=True)
    ]
    with atomic(path) as temporary:
        temporary.write_bytes(lzma.compress(("\n".join(lines) + "\n").encode(), preset=1))
