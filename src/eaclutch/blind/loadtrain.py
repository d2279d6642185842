"""The load cell behind the substrate: stick and slip while driven, the swing after the voltage falls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from eaclutch.blind.film import RELEASE_TIMES
from eaclutch.blind.world import Constants, Runs
from eaclutch.records import FloatArray

SWING_STEP = 4e-6  # s
SWING_STEPS = 6000


@dataclass(frozen=True)
class Friction:
    """Friction forces on the substrate [N], (runs,): static and kinetic, before and while driven."""

    kinetic_before: FloatArray
    static_driven: FloatArray
    kinetic_driven: FloatArray


def normal_base(runs: Runs, c: Constants) -> FloatArray:
    """Normal force on the base [N] (runs,): the film's balance makes it weight and preload, driven or not."""
    carried = runs.preload * (1 - runs.knob("preload_carried"))
    return runs.substrate_weight(c) + runs.film_weight(c) + carried


def side_force(runs: Runs, driven: bool) -> FloatArray:
    """Friction of the film wrapped round the substrate's sides [N] (runs,)."""
    pull = 1 + runs.knob("side_voltage_gain") * runs.voltage**2 if driven else 1.0
    return runs.knob("side_force") * pull


def friction_forces(contact_on: FloatArray, contact_off: FloatArray, runs: Runs, c: Constants) -> Friction:
    """Friction from the contact force on the film [N] (runs,) with and without voltage (physics 9 and 10)."""
    base = normal_base(runs, c)
    kinetic, static = runs.base_kinetic, runs.base_static
    return Friction(
        kinetic_before=kinetic * base + runs.film_kinetic * contact_off + side_force(runs, False),
        static_driven=static * base + runs.film_static * contact_on + 1.15 * side_force(runs, True),
        kinetic_driven=kinetic * base + runs.film_kinetic * contact_on + side_force(runs, True),
    )


def train_stiffness(runs: Runs, c: Constants) -> FloatArray:
    """Stiffness [N/m] (runs,) of load cell and what lies in series with it."""
    return 1 / (1 / c.stiffness + runs.knob("compliance"))


def strengthened(rest: FloatArray, runs: Runs) -> FloatArray:
    """Factor on static friction after ``rest`` seconds at rest; a power of time, 1 at 20 ms."""
    growth = runs.knob("aging_depth")
    return 1 + growth * ((np.maximum(rest, 1e-4) / 0.02) ** 0.15 - 1)


def weakened(speed: FloatArray, runs: Runs) -> FloatArray:
    """Factor on kinetic friction at sliding speed [m/s]: 1 - depth v / (v + v_c)."""
    return 1 - runs.knob("weakening_depth") * speed / (speed + runs.knob("weakening_speed", 1e-3))


def climb(
    friction: Friction,
    start: FloatArray,
    onset: FloatArray,
    runs: Runs,
    c: Constants,
    rng: np.random.Generator,
) -> tuple[list[FloatArray], list[FloatArray], FloatArray, FloatArray]:
    """The driven ramp: knots of force against time since voltage on, per run.

    Returns (times, forces, largest slip as a share of the force before it (NaN: none), force at switch-off).
    Every slip swings half a period of the load cell; the static capacity scatters from slip to slip.
    """
    n = len(runs)
    rate = train_stiffness(runs, c) * c.stage_speed * runs.knob("speed_factor", 1.0)
    mass = c.mass + runs.knob("moving_mass")
    stiffness = train_stiffness(runs, c)
    damping = c.damping + runs.knob("side_damping")
    zeta = damping / (2 * np.sqrt(stiffness * mass))
    swing = np.pi / np.sqrt(stiffness / mass * (1 - zeta**2))
    overshoot = np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2))
    moving_for = runs.drive_time - runs.dwell
    shape = (1 - np.cos(np.pi * np.linspace(0, 1, 9))) / 2
    times: list[list[float]] = [[0.0, onset[i]] for i in range(n)]
    forces: list[list[float]] = [[start[i], start[i]] for i in range(n)]
    worst = np.full(n, np.nan)
    end = np.empty(n)
    for i in range(n):
        one = _Single(runs, i)
        time, force = float(onset[i]), float(start[i])
        for _ in range(4000):
            rest = max((friction.static_driven[i] - force) / rate[i], 1e-3)
            hold = friction.static_driven[i] * one.strengthened(rest)
            hold *= 1 + c.static_scatter * rng.standard_normal()
            reach = time + max(hold - force, 0.0) / rate[i]
            if reach >= moving_for[i]:
                force += rate[i] * (moving_for[i] - time)
                break
            drop_speed = max(hold - friction.kinetic_driven[i], 0.0) / np.sqrt(stiffness[i] * mass[i])
            slide = friction.kinetic_driven[i] * one.weakened(drop_speed)
            low = slide - overshoot[i] * (hold - slide) if hold > slide else hold
            low = max(low, 0.0)
            if hold - low < 1e-6:  # no slip left: it creeps along at the capacity
                force = hold
                times[i].append(reach)
                forces[i].append(hold)
                break
            times[i].extend(reach + shape_t for shape_t in np.linspace(0, 1, 9) * swing[i])
            forces[i].extend(hold + (low - hold) * shape)
            worst[i] = np.fmax(worst[i], (hold - low) / hold)
            time, force = reach + swing[i], low
            if time >= moving_for[i]:
                break
        times[i].append(max(moving_for[i], times[i][-1] + 1e-9))
        forces[i].append(force)
        end[i] = force
    return [np.array(t) for t in times], [np.array(f) for f in forces], worst, end


class _Single:
    """Scalar view of one run's friction knobs, for the event loop."""

    def __init__(self, runs: Runs, i: int):
        self.depth = float(runs.knob("aging_depth")[i])
        self.weak = float(runs.knob("weakening_depth")[i])
        self.speed = float(runs.knob("weakening_speed", 1e-3)[i])

    def strengthened(self, rest: float) -> float:
        return 1 + self.depth * ((max(rest, 1e-4) / 0.02) ** 0.15 - 1) if self.depth else 1.0

    def weakened(self, speed: float) -> float:
        return 1 - self.weak * speed / (speed + self.speed) if self.weak else 1.0


def swing(
    contact: FloatArray, force_at_off: FloatArray, runs: Runs, c: Constants, steps: int = SWING_STEPS
) -> FloatArray:
    """Force on the load cell [N] (steps, runs), every SWING_STEP after the voltage fell.

    ``contact``: F_k on RELEASE_TIMES (times, runs). Linear oscillator, advanced exactly over each step with
    the friction held constant; stuck until k x exceeds static friction; the tip pushes and cannot pull.
    """
    n = len(runs)
    clock = SWING_STEP * np.arange(steps)
    contact_now = np.stack([np.interp(clock, RELEASE_TIMES, contact[:, i]) for i in range(n)], axis=1)
    base = normal_base(runs, c)
    static = runs.base_static * base + contact_now * runs.film_static + 1.15 * side_force(runs, False)
    static = static * strengthened(runs.dwell + 0.01, runs)
    kinetic = runs.base_kinetic * base + contact_now * runs.film_kinetic + side_force(runs, False)
    pushing = _propagators(train_stiffness(runs, c), c.mass + runs.knob("moving_mass"), c, runs)
    free = _propagators(np.full(n, c.stiffness), np.full(n, c.mass), c, None)
    position, speed = force_at_off / train_stiffness(runs, c), np.zeros(n)
    stuck = np.ones(n, bool)
    out = np.empty((steps, n))
    for step in range(steps):
        touching = position > 0
        stiffness = np.where(touching, train_stiffness(runs, c), c.stiffness)
        out[step] = stiffness * position
        stuck = stuck & touching & (out[step] <= static[step])
        push = kinetic[step] * weakened(np.abs(speed), runs)
        # friction acts against the motion; at the turn it acts against the motion about to start
        force = np.where(touching, np.where(speed > 0, -push, push), 0.0)
        a = np.where(touching[:, None, None], pushing, free)
        moved = a[:, 0, 0] * position + a[:, 0, 1] * speed + a[:, 0, 2] * force
        after = a[:, 1, 0] * position + a[:, 1, 1] * speed + a[:, 1, 2] * force
        turned = touching & (speed != 0) & (after * speed < 0)
        stuck = stuck | (turned & (stiffness * np.abs(moved) <= static[step]))
        position, speed = np.where(stuck, position, moved), np.where(stuck, 0.0, after)
    return out


def _propagators(stiffness: FloatArray, mass: FloatArray, c: Constants, runs: Runs | None) -> FloatArray:
    """Exact step of (x, x', constant force): (runs, 3, 3)."""
    damping = c.damping + (runs.knob("side_damping") if runs is not None else np.zeros_like(stiffness))
    system = np.zeros((len(stiffness), 3, 3))
    system[:, 0, 1] = 1
    system[:, 1, 0], system[:, 1, 1], system[:, 1, 2] = -stiffness / mass, -damping / mass, 1 / mass
    return expm(system * SWING_STEP)
