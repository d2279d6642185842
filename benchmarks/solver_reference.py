"""Reference solutions: the full equations of film (h, v) and tip (x, u) together, by scipy, nothing reduced.

No exact oscillator, no separate film: one system of four unknowns in each phase of the friction automaton, with
scipy's event location. The forces come from the same tables (checked apart, against quadrature) or, for the
``plain`` transcription, from ``laws`` with scipy.integrate.quad in every evaluation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from eaclutch.physics.kernels.contact import contact
from eaclutch.physics.kernels.drive import ENGAGING, RELEASING, fields_at
from eaclutch.physics.kernels.film import net_force
from eaclutch.physics.kernels.ramp import driven_run
from eaclutch.physics.kernels.statics import driven_gap, rest_before
from eaclutch.physics.tables import Tables, tables
from eaclutch.records import FloatArray

END = 0.11
Rates = Callable[[float, FloatArray], FloatArray]


@njit(cache=True)
def tension_grown(h, p, gap_before):
    """By how much the film holds more at h than before the voltage [N]."""
    free = max(p.film_free_gap, gap_before)
    now, before = free - h, free - gap_before
    return p.film_spring * (now - before + p.film_hardening * (now**3 - before**3))


@njit(cache=True)
def rates(t, y, p, load, gap_before, phase, mode, table):
    """dy/dt of (h, v, x, u); mode 0: the tip does not move, 1 back, 2 forward, 3 free."""
    net = net_force(p, fields_at(p, t, phase, table), y[0], y[1], load, gap_before, table)
    out = np.empty(4)
    out[0], out[1] = y[1], net / p.film_mass
    out[2], out[3] = 0.0, 0.0
    if mode > 0:
        friction, stiffness, mass, damping = 0.0, p.stiffness, p.mass, p.load_cell_damping
        if mode < 3:
            lift, _ = contact(p, y[0], table)
            base = p.substrate_weight + load + net - tension_grown(y[0], p, gap_before)
            weak = 1.0 - p.weakening_depth * (1.0 - np.exp(-abs(y[3]) / p.weakening_speed))
            friction = weak * (p.base_kinetic * base + p.film_kinetic * lift) + p.side_friction
            friction = friction if mode == 1 else -friction
            stiffness = p.stiffness / (1.0 + p.stiffness * p.series_compliance)
            mass, damping = p.mass + p.added_mass, p.load_cell_damping + p.side_damping
        out[2] = y[3]
        out[3] = (friction - stiffness * y[2] - damping * y[3]) / mass
    return out


@njit(cache=True)
def static_margin(t, y, p, load, gap_before, table):
    """Static friction less the tip's force [N]."""
    net = net_force(p, fields_at(p, t, RELEASING, table), y[0], y[1], load, gap_before, table)
    lift, _ = contact(p, y[0], table)
    base = p.substrate_weight + load + net - tension_grown(y[0], p, gap_before)
    static = p.static_factor_release * (p.base_static * base + p.film_static * lift) + p.side_friction_static
    kinetic = p.base_kinetic * base + p.film_kinetic * lift + p.side_friction
    return max(static, kinetic) - p.stiffness / (1.0 + p.stiffness * p.series_compliance) * y[2]


def _event(function: Callable[[float, FloatArray], float], direction: float) -> Callable:
    function.terminal, function.direction = True, direction  # type: ignore[attr-defined]
    return function


def engagement(p: np.void, fraction: float, method: str, rtol: float, table: Tables | None = None) -> float:
    """Engagement time [s]."""
    table = tables() if table is None else table
    preload, before = rest_before(p, table)
    _, driven = driven_gap(p, preload, before, table)
    way = fraction * (before - driven)
    load = preload + p["film_weight"]
    scale = np.array([way, way / 1e-6, 1.0, 1.0])
    crossed = _event(lambda t, y: y[0] - (before - way), -1)
    result = solve_ivp(
        lambda t, y: rates(t, y, p, load, before, ENGAGING, 0, table), (0.0, 0.1), [before, 0.0, 0.0, 0.0],
        method=method, rtol=rtol, atol=rtol * scale, events=crossed, first_step=1e-10,
    )  # fmt: skip
    return float(result.t_events[0][0])


def release(p: np.void, method: str, rtol: float, table: Tables | None = None) -> tuple[int, FloatArray]:
    """(status 0 ok, 2 never slips; (release 10, 50, 90 %, final force)) [s, s, s, N]."""
    table = tables() if table is None else table
    preload, before = rest_before(p, table)
    _, driven = driven_gap(p, preload, before, table)
    load = preload + p["film_weight"]
    start = driven_run(p, driven, before, table)[2]
    k = float(p["stiffness"] / (1.0 + p["stiffness"] * p["series_compliance"]))
    share = float(p["mass"] / (p["mass"] + p["added_mass"]))
    way = before - driven
    x0 = start / k
    scale = np.array([way, way / 1e-5, x0, x0 * 4000.0])

    def zero_speed(t, y):
        return y[3]

    def at_contact(t, y):
        return y[2]

    def holds(t, y):
        return static_margin(t, y, p, load, before, table)

    t, y, mode = 0.0, np.array([driven, 0.0, x0, 0.0]), 0
    pieces, moved = [], False
    if holds(t, y) < 0:
        mode = 1
    for _ in range(60):
        # an event function that is zero at the start must not fire there: scipy needs a sign change
        events = {
            0: [(holds, -1)],
            1: [(zero_speed, 1), (at_contact, -1)],
            2: [(zero_speed, -1)],
            3: [(at_contact, 1)],
        }
        result = solve_ivp(
            lambda t, y, mode=mode: rates(t, y, p, load, before, RELEASING, mode, table), (t, END), y, method=method,
            rtol=rtol, atol=rtol * scale, dense_output=True, events=[_event(f, d) for f, d in events[mode]],
            first_step=1e-9,
        )  # fmt: skip
        pieces.append((t, result.t[-1], result.sol, float(p["stiffness"]) if mode == 3 else k))
        t, y = result.t[-1], result.y[:, -1].copy()
        if result.status != 1:
            break
        if mode == 0:
            mode, moved = 1, True
        elif mode == 1 and len(result.t_events[0]):
            mode, y[3] = 0, 0.0
        elif mode == 1:
            mode, y[2] = 3, 0.0
        elif mode == 2:
            y[3] = 0.0
            mode = 0 if holds(t, y) >= 0 else 1
        else:
            mode, y[2], y[3] = 2, 0.0, y[3] * share
        moved = True
    if not moved and mode == 0:
        return 2, np.full(4, np.nan)
    final = float(np.mean(_force(pieces, np.linspace(0.01, min(END, pieces[-1][1]), 2001))))
    times = [_crossing(pieces, start - part * (start - final)) for part in (0.1, 0.5, 0.9)]
    return 0, np.array([*times, final])


def _force(pieces: list, times: FloatArray) -> FloatArray:
    out = np.empty(times.shape)
    for a, b, solution, k in pieces:
        inside = (times >= a) & (times <= b)
        if inside.any():
            out[inside] = k * solution(times[inside])[2]
    return out


def _crossing(pieces: list, level: float) -> float:
    for a, b, solution, k in pieces:
        grid = np.unique(np.concatenate([np.linspace(a, b, 400), solution.ts]))
        force = k * solution(grid)[2]
        below = np.flatnonzero(force <= level)
        if len(below) == 0:
            continue
        i = below[0]
        if i == 0:
            return a
        low, high = grid[i - 1], grid[i]
        for _ in range(60):
            middle = 0.5 * (low + high)
            if k * solution(middle)[2] <= level:
                high = middle
            else:
                low = middle
        return float(high)
    return np.nan
