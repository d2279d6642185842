"""A contact whose friction runs after its force: L' = (F - L) / lag, F the contact force of a film that opens."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import compiled

# Of a step, so that a quintic follows the friction: so many lags, or such a share of the driven contact force gone.
LAGS_A_STEP, LAG_A_STEP = 0.5, 0.02
CAUGHT_UP = 1e-5  # of the contact force at rest, from which the friction no longer lags


@compiled
def longest_step(lag, late, force, driven):
    """The longest step [s] from a contact force ``force`` whose friction stands at ``late`` [N]; ``driven``: the one
    at switch-off."""
    return lag * max(LAGS_A_STEP, LAG_A_STEP * driven / (abs(late - force) + 1e-300))


@compiled
def late_ends(ends, late, dt, lag, share):
    """``ends`` of a step (value and slope of the contact force at its start, middle and end) with a ``share`` of it
    late, and where that share stands at the end."""
    a, slope_a, b, slope_b, c, slope_c = ends
    middle, end = _run_after(late, (a, b, c), dt, lag)
    now, rate = 1.0 - share, share / lag
    mixed = (
        now * a + share * late, now * slope_a + rate * (a - late),
        now * b + share * middle, now * slope_b + rate * (b - middle),
        now * c + share * end, now * slope_c + rate * (c - end),
    )  # fmt: skip
    return mixed, end


@compiled
def _run_after(start, forces, dt, lag):
    """L (middle, end) of a step from ``start``, F the parabola through ``forces`` at its start, middle and end: the
    parabola that L runs after, and what is left of the distance to it."""
    a, b, c = forces
    bend = 2.0 * (a - 2.0 * b + c) / (dt * dt)
    slope = (4.0 * b - 3.0 * a - c) / dt - 2.0 * lag * bend
    level = a - lag * slope
    half, apart = 0.5 * dt, start - level
    middle = level + half * (slope + half * bend) + apart * math.exp(-half / lag)
    return middle, level + dt * (slope + dt * bend) + apart * math.exp(-dt / lag)
