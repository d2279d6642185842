"""The film at rest: preload from the friction before, the gap without and with voltage, the capacity."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import compiled
from eaclutch.physics.kernels.contact import adhesion, contact, log_load
from eaclutch.physics.kernels.forces import driven_field, field_slopes, held_field, tension

OK, PULL_IN, NEVER_SLIPS, TIMED_OUT = 0, 1, 2, 3
CLOSED = (
    1e-3  # a mean gap below this fraction of sigma counts as pulled in: the squeezed air has nowhere to be
)
LEAST_LOAD = (
    1e-4  # N; a preload below this (friction before at or under the strip's own weight) is taken as this
)


@compiled
def weakened(p, speed):
    """Kinetic friction's factor at a sliding speed [m/s]."""
    if p.weakening_depth == 0.0:
        return 1.0
    return 1.0 - p.weakening_depth * (1.0 - math.exp(-abs(speed) / p.weakening_speed))


@compiled
def gap_at_load(p, load, tables):
    """Gap at which the contact alone carries ``load`` [N]: Newton on log F_k, which is concave in h. Its mean over a
    spread of gaps is, too, but for what four nodes leave of it; a wide spread that the load makes smaller may snap
    shut: hence the clamp and the bracket."""
    target = math.log(load / p.contact_scale)
    x = (
        math.sqrt(max(-2.0 * target - 1.8 * math.log(max(-2.0 * target, 1.0)) - 2.0, 0.0))
        if target < -1.0
        else -1.0
    )
    low, high = -math.inf, math.inf
    for _ in range(80):
        if p.gap_half_spread == 0.0:
            value, slope = log_load(p, x, tables)
        else:
            force, force_slope = contact(p, x * p.sigma, tables)
            value, slope = math.log(force / p.contact_scale), force_slope / force * p.sigma
        if value > target:
            low = x
        else:
            high = x
        # where it snaps the slope points away from the gap
        step = (value - target) / slope if slope < 0.0 else target - value
        new = x - min(max(step, -2.0), 2.0)
        if new < low or new > high:
            new = 0.5 * (low + high)
        step, x = x - new, new
        if abs(step) < 1e-13:
            break
    return x * p.sigma


@compiled
def rest_before(p, tables):
    """(preload [N], gap before [m]): the preload at which the kinetic friction at stage speed equals the measured
    friction before the voltage: mu_b (m_s g + L) + mu_d (L + F_adh) + side friction, L = preload + film weight."""
    factor = weakened(p, p.stage_speed)
    base, film = p.base_kinetic * factor, p.film_kinetic * factor
    load = (p.friction_before - p.side_friction - base * p.substrate_weight) / (base + film)
    least = LEAST_LOAD + p.film_weight
    if p.adhesion_force == 0.0:
        load = max(load, least)
        return load - p.film_weight, gap_at_load(p, load, tables)
    total, attraction = max(load, least), 0.0
    gap = gap_at_load(p, total, tables)
    for _ in range(100):  # damped fixed point: the attraction is a small part of the friction
        attraction, _ = adhesion(p, gap, tables)
        new_load = max(load - film * attraction / (base + film), least)
        new_gap = gap_at_load(p, new_load + attraction, tables)
        change = new_gap - gap
        gap += 0.7 * change
        total = new_load
        if abs(change) < 1e-13 * p.sigma:
            break
    return total - p.film_weight, gap


@compiled
def net_log(p, h, load, gap_before, force, force_h, tables):
    """(log of what lifts over what presses, its slope in h); positive where the film is pushed up."""
    up, up_h = contact(p, h, tables)
    held, stiff = tension(p, gap_before, h)
    up += held
    up_h -= stiff
    pull, pull_h = adhesion(p, h, tables)
    down, down_h = force + pull + load, force_h + pull_h
    return math.log(up / down), up_h / up - down_h / down


@compiled
def driven_gap(p, preload, gap_before, tables):
    """(status, gap [m]) with the voltage on."""
    return gap_in_field(p, driven_field(p), preload, gap_before, tables)


@compiled
def held_gap(p, preload, gap_before, tables):
    """(status, gap [m]) at the end of the hold."""
    return gap_in_field(p, held_field(p), preload, gap_before, tables)


@compiled
def gap_in_field(p, field, preload, gap_before, tables):
    """(status, gap [m]) in a steady field: the first equilibrium below the gap without voltage.

    The film comes from ``gap_before``; log(F_k) is concave and the load's log convex, so Newton from above is
    monotone. Where the slope turns the film would run on: it is followed in small steps to the next equilibrium.
    """
    load = preload + p.film_weight
    floor = CLOSED * p.sigma
    h = gap_before
    high, low = gap_before, floor
    for _ in range(80):
        force, force_h, _, _ = field_slopes(p, field, h, tables)
        value, slope = net_log(p, h, load, gap_before, force, force_h, tables)
        if value > 0.0:
            low = h
        else:
            high = h
        if slope < 0.0:
            new = h - value / slope
            if new <= low or new > high:
                new = 0.5 * (low + high) if low > floor else h - min(0.25 * p.sigma, 0.5 * (h - floor))
        elif value > 0.0:
            new = 0.5 * (low + high)
        else:
            new = h - 0.05 * p.sigma
        if new <= floor * 1.0000001:
            return PULL_IN, floor
        if abs(new - h) < 1e-12 * p.sigma:
            return OK, new
        h = new
    if low > floor:
        return OK, h
    return PULL_IN, floor


@compiled
def frictions(p, normal_base, contact_force, static_factor, speed):
    """(static, kinetic) friction [N] of the strip between base and film with the voltage on; kinetic at ``speed``."""
    factor = weakened(p, speed)
    static = static_factor * (p.base_static * normal_base + p.film_static * contact_force)
    kinetic = factor * (p.base_kinetic * normal_base + p.film_kinetic * contact_force)
    static += p.side_friction_static + p.side_pull * p.film_static / p.film_kinetic
    kinetic += p.side_friction + p.side_pull
    return softened(p, static), softened(p, kinetic)


@compiled
def softened(p, friction):
    """A friction [N] that falls behind its load: F / (1 + (s F)^n)^(1 / n)."""
    if p.softening == 0.0 or friction <= 0.0:
        return friction
    return friction / (1.0 + (p.softening * friction) ** p.softening_power) ** (1.0 / p.softening_power)
