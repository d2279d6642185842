"""The driven part of a run: the climb to the static capacity, stick-slip, the state at switch-off."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import compiled
from eaclutch.physics.kernels.contact import adhesion, contact
from eaclutch.physics.kernels.forces import driven_field, field_force, held_field
from eaclutch.physics.kernels.statics import NEVER_SLIPS, OK, frictions

LEVEL_SPAN = 3e-3  # s before voltage off whose median is the force at switch-off (contract)


@compiled
def train_stiffness(p):
    """Stiffness [N/m] of load cell and series compliance while the tip moves and pushes."""
    return p.stiffness / (1.0 + p.stiffness * p.series_compliance)


@compiled
def stuck_stiffness(p):
    """Stiffness [N/m] that the stage climbs against while the strip sticks to the film: the film shears as well."""
    return p.stiffness / (1.0 + p.stiffness * (p.series_compliance + p.film_compliance))


@compiled
def driven_friction(p, gap, gap_before, tables):
    """(static, kinetic) friction [N] at rest with the voltage on, kinetic at the mean speed of a slip."""
    return friction_in_field(p, driven_field(p), gap, gap_before, tables)


@compiled
def friction_in_field(p, field, gap, gap_before, tables):
    """(static, kinetic) friction [N] at rest in a steady field, kinetic at the mean speed of a slip."""
    lift, _ = contact(p, gap, tables)
    pull, _ = adhesion(p, gap, tables)
    force = field_force(p, field, gap, tables)
    normal_base = p.substrate_weight + lift - force - pull
    static, kinetic = frictions(p, normal_base, lift, p.static_factor_ramp, 0.0)
    if p.weakening_depth != 0.0:
        k = train_stiffness(p)
        omega = math.sqrt(k / (p.mass + p.added_mass))
        for _ in range(4):
            speed = 2.0 / math.pi * max(static - kinetic, 0.0) / k * omega
            _, kinetic = frictions(p, normal_base, lift, p.static_factor_ramp, speed)
    return static, kinetic


@compiled
def slip_bottom(p, static, kinetic):
    """Force [N] at which a slip ends: it overshoots the kinetic friction by the load cell's own damping."""
    k, mass = train_stiffness(p), p.mass + p.added_mass
    damping = (p.load_cell_damping + p.side_damping) / (2.0 * math.sqrt(k * mass))
    if p.load_cell_dynamic == 0.0 or damping >= 1.0:
        return min(kinetic, static)
    overshoot = math.exp(-math.pi * damping / math.sqrt(1.0 - damping * damping))
    return max(min(kinetic - overshoot * (static - kinetic), static), 0.0)


@compiled
def ramp_slope(start, top, bottom, rate, delay, t0, t1):
    """Least-squares slope [N/s] over [t0, t1] of the sawtooth that stays at ``start`` for ``delay``, climbs from it
    at ``rate`` to ``top``, drops to ``bottom`` and climbs again."""
    middle, sum_ft = 0.5 * (t0 + t1), 0.0
    begin, level = delay, start
    flat = min(delay, t1)
    if flat > t0:  # integral of start (t - middle)
        sum_ft = start * 0.5 * (flat - t0) * (flat - t1)
    # slips of 0.1 mN at least, so that the sawtooth moves on, and a thousand of them in the window are enough
    fall = max(top - bottom, 1e-3 * top, 1e-4, 1e-3 * rate * t1)
    while begin < t1:
        end = begin + max(top - level, 0.0) / rate
        a, b = max(begin, t0), min(end, t1)
        if b > a:  # integral of (level + rate (t - begin)) (t - middle)
            u, v = a - middle, b - middle
            intercept = level + rate * (middle - begin)
            sum_ft += intercept * 0.5 * (v * v - u * u) + rate * (v * v * v - u * u * u) / 3.0
        begin, level = end, top - fall
    return 12.0 * sum_ft / (t1 - t0) ** 3


@compiled
def driven_run(p, gap, gap_before, tables):
    """(status, largest force, force at switch-off, slip fraction, ramp slope, early, late, the model's own force at
    switch-off) [N, N, 1, N/s, N].

    The force climbs from the friction before once the drive's delay is over. Where the measured force at switch-off is
    not given the model's is used: on the ramp while it has not slipped, after that bottom + slip_phase (top - bottom):
    the static capacity scatters by a few percent from slip to slip, so the phase of the sawtooth is lost after the
    first slips.
    """
    static, kinetic = driven_friction(p, gap, gap_before, tables)
    bottom = slip_bottom(p, static, kinetic)
    rate = stuck_stiffness(p) * p.stage_speed
    start = p.friction_before
    reach = start + rate * max(p.drive_duration - p.dwell - p.drive_delay, 0.0)
    status = OK
    if reach < static:
        status = NEVER_SLIPS
        largest, switch_off = reach, reach
    else:
        largest = max(static, start)
        switch_off = bottom + p.slip_phase * (static - bottom)
    own = switch_off
    if not math.isnan(p.switch_off_force):
        switch_off = p.switch_off_force
    ramp = ramp_slope(start, static, bottom, rate, p.drive_delay, 2e-3, 20e-3)
    early = ramp_slope(start, static, bottom, rate, p.drive_delay, 0.5e-3, 5e-3)
    late = ramp_slope(start, static, bottom, rate, p.drive_delay, 50e-3, 200e-3)
    return status, largest, switch_off, (static - bottom) / static, ramp, early, late, own


@compiled
def climb_since_level(p):
    """By how much [N] the force stands above the median of its last 3 ms when the voltage falls: the stage goes on
    until it rests, and the strip sticks to it; without a voltage it slides."""
    if p.voltage == 0.0:
        return 0.0
    return stuck_stiffness(p) * p.stage_speed * max(0.5 * LEVEL_SPAN - p.dwell, 0.0)


@compiled
def force_after_hold(p, force, gap, gap_before, tables):
    """``force`` [N], or where less than it sticks at the end of the hold (``gap`` [m]) what the slips there leave."""
    static, kinetic = friction_in_field(p, held_field(p), gap, gap_before, tables)
    if force <= static:
        return force
    bottom = slip_bottom(p, static, kinetic)
    return bottom + p.slip_phase * (static - bottom)
