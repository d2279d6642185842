"""All runs of a campaign through the laws: the force that the load cell would show without noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eaclutch.blind.contact import contact_force, rest_gap
from eaclutch.blind.film import engagement_delay, release_motion
from eaclutch.blind.loadtrain import SWING_STEP, Friction, climb, friction_forces, swing, train_stiffness
from eaclutch.blind.world import Constants, Runs
from eaclutch.records import FloatArray

VOLTAGE_ON = 2.0  # s after the stage starts


@dataclass(frozen=True)
class Motion:
    """Noiseless behaviour of every run; lists and arrays are (runs,), times count from voltage on or off.

    ramp_times, ramp_forces: knots of the driven force; release: force (steps, runs) each SWING_STEP after
    the voltage fell; start_rate: slope [N/s] with which the load cell is wound up before the first slide.
    """

    before: FloatArray
    ramp_times: list[FloatArray]
    ramp_forces: list[FloatArray]
    release: FloatArray
    largest_slip: FloatArray
    at_off: FloatArray
    static_before: FloatArray
    start_rate: FloatArray
    pulled_in: FloatArray


@dataclass(frozen=True)
class Rest:
    """Every run at rest: gaps without and with voltage [m], onset of the rise [s], friction; (runs,)."""

    gap_off: FloatArray
    gap_on: FloatArray
    pulled_in: FloatArray
    onset: FloatArray
    friction: Friction


def at_rest(runs: Runs, c: Constants) -> Rest:
    """Gaps, closing time and friction of all runs."""
    gap_off, _ = rest_gap(runs, c, np.zeros(len(runs)), runs.kappa)
    gap_on, pulled_in = rest_gap(runs, c, runs.voltage, runs.kappa)
    onset = engagement_delay(gap_off, gap_on, runs, c)
    friction = friction_forces(contact_force(gap_on, runs, c), contact_force(gap_off, runs, c), runs, c)
    return Rest(gap_off, gap_on, pulled_in, onset, friction)


def move(runs: Runs, c: Constants, rng: np.random.Generator) -> Motion:
    """Solve all runs: gaps at rest, release of the film, stick-slip, swing. ``rng``: slip-to-slip scatter."""
    state = at_rest(runs, c)
    friction = state.friction
    times, forces, slips, at_off = climb(friction, friction.kinetic_before, state.onset, runs, c, rng)
    gaps = release_motion(state.gap_on, runs, c)
    contact = np.stack([contact_force(gap, runs, c) for gap in gaps])
    return Motion(
        before=friction.kinetic_before,
        ramp_times=times,
        ramp_forces=forces,
        release=swing(contact, at_off, runs, c),
        largest_slip=slips,
        at_off=at_off,
        static_before=friction.kinetic_before * 1.12,
        start_rate=train_stiffness(runs, c) * c.stage_speed,
        pulled_in=state.pulled_in,
    )


def force_of(
    motion: Motion, runs: Runs, i: int, time: FloatArray, on: float, free: float = 0.0
) -> FloatArray:
    """True force on the load cell of run ``i`` [N] at ``time`` since the stage started (samples,).

    ``free``: for how long the tip has not met the substrate yet [s]; 0: the run begins in contact.
    """
    off = on + float(runs.drive_time[i])
    wind = free + motion.static_before[i] / motion.start_rate[i]
    begin = 0.0 if free > 0 else 0.9 * motion.before[i]
    release = motion.release[:, i]
    knots = np.concatenate(
        [
            [0.0, free, wind, wind + 1e-3],
            on + motion.ramp_times[i],
            [off],
            off + SWING_STEP * np.arange(1, len(release)),
        ]
    )
    values = np.concatenate(
        [
            [begin, begin, motion.static_before[i], motion.before[i]],
            motion.ramp_forces[i],
            [motion.ramp_forces[i][-1]],
            release[1:],
        ]
    )
    return np.interp(time, knots, values)
