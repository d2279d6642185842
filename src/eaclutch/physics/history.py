"""A whole run as the load cell would read it without noise: friction before, ramp, stick-slip, hold, release."""

from __future__ import annotations

import math

import numpy as np

from eaclutch.physics.kernels.batch import RESULTS, STATUSES, simulate, trace
from eaclutch.physics.kernels.ramp import (
    climb_since_level,
    driven_friction,
    force_after_hold,
    slip_bottom,
    stuck_stiffness,
    train_stiffness,
)
from eaclutch.physics.kernels.readout import lagged
from eaclutch.physics.kernels.release import force_at
from eaclutch.physics.kernels.tip import COLUMNS, SEGMENTS
from eaclutch.physics.prediction import Status
from eaclutch.physics.tables import tables
from eaclutch.records import FloatArray, InputError

MOST_SLIPS = 5000


def run_history(
    row: np.void, time: FloatArray, capacity_factors: FloatArray | None = None, tolerance: float = 1e-5
) -> FloatArray:
    """Reading [N] (samples,) at ``time`` [s] from the logged voltage-on edge; see ClutchModel.history.

    Raises InputError where the parameters let the film pull in: there is no equilibrium to start from.
    """
    table = tables()
    out, status = np.empty(len(RESULTS)), np.empty(len(STATUSES), dtype=np.int8)
    segments, work = np.empty((SEGMENTS, COLUMNS)), np.empty((4, 6))
    driven = bool(row["voltage"] > 0.0)
    simulate(row, table, driven, False, 0.005, tolerance, segments, work, out, status)
    if status[0] == Status.pull_in:
        raise InputError(
            "parameters", "the film pulls in under this voltage", "lower the voltage or the force"
        )
    before = float(row["friction_before"])
    onset = float(out[9]) if driven and status[1] == Status.ok else 0.0
    off = float(row["drive_duration"])
    stop = off - float(row["dwell"])
    force = np.full(time.shape, before)
    if driven:
        static, kinetic = driven_friction(row, out[2], out[1], table)
        cycle = (time > onset) & (time <= off)
        force[cycle], held = _stick_slip(
            row, time[cycle], onset, stop, before, static, kinetic, capacity_factors
        )
    else:
        held = before
    after = time > off
    if after.any():
        start = row.copy()
        if math.isnan(start["switch_off_force"]):
            start["switch_off_force"] = force_after_hold(row, held, out[15], out[1], table)
        else:  # the run is known to have ended at this force: the hold says so too
            start["switch_off_force"] += climb_since_level(row)
            force[(time > stop) & (time <= off)] = start["switch_off_force"]
        _, n, level, _ = trace(start, table, tolerance, segments, work)
        delay = float(row["drive_delay"])
        moving = [force_at(segments, n, t - off - delay, level) if n else level for t in time[after]]
        force[after] = moving
    drifted = force + float(row["reading_drift"]) * np.clip(time, 0.0, off)
    return _read(drifted, time, float(row["readout_time"]))


def _read(force: FloatArray, time: FloatArray, time_constant: float) -> FloatArray:
    """What a readout with a low pass makes of the force."""
    if time_constant <= 0.0:
        return force
    read = force.copy()
    for i in range(1, len(time)):
        read[i] = lagged(force[i - 1], force[i], read[i - 1], time[i] - time[i - 1], time_constant)
    return read


def _stick_slip(
    row: np.void, time: FloatArray, onset: float, stop: float, start: float, static: float, kinetic: float,
    factors: FloatArray | None,
) -> tuple[FloatArray, float]:  # fmt: skip
    """Reading while driven, and the force at which the stage leaves the tip when it stops."""
    stiffness = train_stiffness(row)
    rate = stuck_stiffness(row) * float(row["stage_speed"])
    mass = float(row["mass"] + row["added_mass"])
    beta = 0.5 * float(row["load_cell_damping"] + row["side_damping"]) / mass
    omega = math.sqrt(max(stiffness / mass - beta**2, 1e-6))
    fall = math.pi / omega if row["load_cell_dynamic"] else 0.0
    force = np.empty(time.shape)
    begin, level, slip = onset, start, 0
    while True:
        factor = 1.0 if factors is None or len(factors) == 0 else float(factors[min(slip, len(factors) - 1)])
        top = max(static * factor, level)
        low = min(kinetic * factor, top)
        end = begin + (top - level) / rate
        climb = (time > begin) & (time <= min(end, stop))
        force[climb] = level + rate * (time[climb] - begin)
        if end >= stop:
            held = level + rate * max(stop - begin, 0.0)
            force[time > stop] = held
            return force, held
        bottom = slip_bottom(row, top, low)
        slide = (time > end) & (time <= end + fall)
        s = time[slide] - end
        swing = np.exp(-beta * s) * (np.cos(omega * s) + beta / omega * np.sin(omega * s))
        force[slide] = np.maximum(low + (top - low) * swing, bottom)
        if end + fall >= stop:
            force[time > end + fall] = bottom
            return force, bottom
        begin, level, slip = end + fall, min(bottom, top - 1e-3 * top), slip + 1
        if slip >= MOST_SLIPS:  # far finer than any record: the middle of the sawtooth
            held = 0.5 * (bottom + top)
            force[time > begin] = held
            return force, held
