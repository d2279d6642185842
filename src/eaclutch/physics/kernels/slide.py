"""The two-state friction automaton of the tip over one film step (paper eq. for the load cell, physics 11)."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import compiled
from eaclutch.physics.kernels.ramp import train_stiffness
from eaclutch.physics.kernels.statics import weakened
from eaclutch.physics.kernels.tip import (
    BACK,
    FOLLOW,
    FORWARD,
    FREE,
    SEGMENTS,
    STEP_PHASE,
    STUCK,
    oscillate,
    root_of_v,
    root_of_x,
    set_segment,
)

# What the automaton remembers between film steps.
MODE, X, V, COUNT = 0, 1, 2, 3


@compiled
def polynomial(f, s):
    """Value of f0 + f1 s + .. + f5 s^5."""
    return f[0] + s * (f[1] + s * (f[2] + s * (f[3] + s * (f[4] + s * f[5]))))


@compiled
def shift(f, s, out):
    """``out``: the coefficients of f(s + .), by repeated synthetic division."""
    for i in range(6):
        out[i] = f[i]
    for i in range(5):
        for j in range(4, i - 1, -1):
            out[j] += s * out[j + 1]


@compiled
def _friction_segment(p, segment, t0, s, length, x, v, sign, kinetic, stiffness, mass, damping, out):
    """Solve one sliding segment; velocity weakening by iterating the friction along the segment's own speed."""
    if p.weakening_depth == 0.0:
        shift(kinetic, s, out)
        out[0] += p.side_friction
        set_segment(segment, t0, length, x, v, mass, damping, stiffness, out, sign)
        return
    v_middle, v_end = v, v
    half = 0.5 * length
    out[3], out[4], out[5] = 0.0, 0.0, 0.0
    for _ in range(4):
        a = polynomial(kinetic, s) * weakened(p, v)
        b = polynomial(kinetic, s + half) * weakened(p, v_middle)
        c = polynomial(kinetic, s + length) * weakened(p, v_end)
        out[0] = a + p.side_friction
        out[1], out[2] = (4.0 * b - 3.0 * a - c) / length, 2.0 * (a - 2.0 * b + c) / (length * length)
        set_segment(segment, t0, length, x, v, mass, damping, stiffness, out, sign)
        _, v_middle = oscillate(segment, half)
        _, v_end = oscillate(segment, length)


@compiled
def _segment_length(p, omega, v, mass, kinetic):
    length = STEP_PHASE / omega
    if p.weakening_depth != 0.0:
        rate = abs(kinetic) * p.weakening_depth / (mass * p.weakening_speed)
        rate *= math.exp(-abs(v) / p.weakening_speed)
        length = min(length, max(0.04 / max(rate, 1e-9), length / 400.0))
    return length


@compiled
def advance(p, state, segments, t0, span, kinetic, static, spare):
    """Move the tip over [t0, t0 + span]; ``kinetic``, ``static``: polynomials of the friction (kinetic without side
    friction and weakening). Returns False when the segments are used up."""
    pushing = train_stiffness(p)
    heavy = p.mass + p.added_mass
    s = 0.0
    while s < span:
        mode, x, v, n = int(state[MODE]), state[X], state[V], int(state[COUNT])
        if n >= SEGMENTS - 1:
            return False
        if mode == STUCK:
            s = _release_from_stick(state, pushing * x, s, span, kinetic, static, p.side_friction)
            continue
        free = mode == FREE
        stiffness, mass = (p.stiffness, p.mass) if free else (pushing, heavy)
        damping = p.load_cell_damping if free else p.load_cell_damping + p.side_damping
        omega = math.sqrt(stiffness / mass)
        length = min(_segment_length(p, omega, v, mass, polynomial(kinetic, s)), span - s)
        segment = segments[n]
        if free:
            set_segment(segment, t0 + s, length, x, v, mass, damping, stiffness, kinetic, 0.0)
        else:
            sign = 1.0 if mode == BACK else -1.0
            _friction_segment(
                p, segment, t0 + s, s, length, x, v, sign, kinetic, stiffness, mass, damping, spare
            )
        s += _move(p, state, segment, length, s, pushing, kinetic, static)
        state[COUNT] += 1
        if span - s < 1e-15:
            break
    return True


@compiled
def _release_from_stick(state, force, s, span, kinetic, static, side_friction):
    """The time at which static friction falls to the force, or the end of the step; sets the mode."""
    if max(polynomial(static, s), polynomial(kinetic, s) + side_friction) < force:
        state[MODE], state[V] = BACK, 0.0
        return s
    if max(polynomial(static, span), polynomial(kinetic, span) + side_friction) >= force:
        return span
    low, high = s, span
    for _ in range(60):
        middle = 0.5 * (low + high)
        if max(polynomial(static, middle), polynomial(kinetic, middle) + side_friction) < force:
            high = middle
        else:
            low = middle
        if high - low < 1e-13:
            break
    state[MODE], state[V] = BACK, 0.0
    return high


@compiled
def _move(p, state, segment, length, s, pushing, kinetic, static):
    """Go to the segment's end or its first event; returns the time gone and sets mode, x, v."""
    mode = int(state[MODE])
    x, v = oscillate(segment, length)
    if mode == FREE:
        if x > 0.0 and v > 0.0:
            length = root_of_x(segment, 0.0, 0.0, length)
            _, v = oscillate(segment, length)
            # the strip's share of the mass is taken along at once
            state[MODE], x, v = FORWARD, 0.0, v * p.mass / (p.mass + p.added_mass)
    elif mode == BACK:
        stop = v > 0.0
        at = root_of_v(segment, 1.0, 0.0, length) if stop else length
        x_stop, _ = oscillate(segment, at)
        if x_stop < 0.0:
            length = root_of_x(segment, 0.0, 0.0, at)
            _, v = oscillate(segment, length)
            state[MODE], x = FREE, 0.0
        elif stop:
            length, x, v = at, x_stop, 0.0
            state[MODE] = STUCK
    elif v < 0.0:
        length = root_of_v(segment, -1.0, 0.0, length)
        x, _ = oscillate(segment, length)
        x, v = max(x, 0.0), 0.0
        holds = max(polynomial(static, s + length), polynomial(kinetic, s + length) + p.side_friction)
        state[MODE] = STUCK if pushing * x <= holds else BACK
    segment[1] = length
    state[X], state[V] = x, v
    return length


@compiled
def follow(p, state, segments, t0, span, kinetic, static, spare):
    """Without load-cell dynamics: the reading falls with the kinetic friction once the static one lets go."""
    stiffness = train_stiffness(p)
    n = int(state[COUNT])
    if n >= SEGMENTS - 3:
        return False
    s = 0.0
    if state[MODE] != FOLLOW:
        s = _release_from_stick(state, stiffness * state[X], 0.0, span, kinetic, static, p.side_friction)
        if int(state[MODE]) != BACK:
            return True
        state[MODE] = FOLLOW
    if span - s > 0.0:
        segment = segments[n]
        segment[0], segment[1], segment[6] = t0 + s, span - s, stiffness
        segment[2], segment[3], segment[4], segment[5] = 0.0, 0.0, 0.0, 0.0
        shift(kinetic, s, spare)
        spare[0] += p.side_friction
        for i in range(10):
            segment[7 + i] = spare[i] / stiffness if i < 6 else 0.0
        state[X], _ = oscillate(segment, span - s)
        state[COUNT] += 1
    return True
