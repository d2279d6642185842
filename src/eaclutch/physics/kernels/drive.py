"""The drive's history after an edge: voltage, polarisation and what a residual field leaves, as fields."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import inlined
from eaclutch.physics.kernels.forces import field_force, field_slopes, make_field
from eaclutch.physics.kernels.lookup import relaxation

RELEASING, ENGAGING = 0, 1
SPENT = 1e-16  # of V0^2: below this a falling voltage is off
SPENT_AFTER = 18.5  # time constants; exp(-2 x 18.5) < SPENT
LEAST_STRAIGHTNESS = 1e-6  # below it an edge is an exponential
NO_FIELD = (0.0, 1.0, 1.0, 1.0, 1.0, 0, 0.0)


@inlined
def edge(time_constant, straightness, t):
    """(what is left of an edge, its rate of decay [1/s]) at t: the left u falls as -du/dt = u^(1 - s) / time_constant,
    an exponential for a straightness s of 0 and a straight line for 1."""
    if straightness < LEAST_STRAIGHTNESS:
        if t >= SPENT_AFTER * time_constant:
            return 0.0, 0.0
        left = math.exp(-t / time_constant)
        return left, left / time_constant
    base = 1.0 - straightness * t / time_constant
    if base <= 0.0:
        return 0.0, 0.0
    left = base ** (1.0 / straightness)
    return left, left / (base * time_constant)


@inlined
def history(p, t, phase, tables):
    """((V/V0)^2, its rate, kappa, its rate) at t after an edge: exponential or straighter edge, Cole-Cole step
    response (Mittag-Leffler), continuous at t = 0."""
    decay, rate = edge(
        p.fall_time_constant if phase == RELEASING else p.rise_time_constant, p.edge_straightness, t
    )
    if phase == RELEASING:
        kept = 1.0 - p.residual_fraction * p.residual_fraction
        ratio, ratio_rate = kept * decay * decay, -2.0 * kept * decay * rate
    else:
        ratio, ratio_rate = (1.0 - decay) ** 2, 2.0 * (1.0 - decay) * rate
    kappa, kappa_rate = p.kappa_driven, 0.0
    if p.relaxing != 0.0 and ratio > SPENT:
        left, slope = relaxation(p.exponent, t / p.relaxation_time, tables.relaxation)
        if phase == ENGAGING:
            left, slope = 1.0 - left, -slope
        span = p.relaxing * (p.kappa_driven - p.kappa_infinity)
        kappa = p.kappa_driven - span * (1.0 - left)
        kappa_rate = span * slope / t if t > 0.0 else 0.0
    return ratio, ratio_rate, kappa, kappa_rate


@inlined
def residual_left(p, t, phase):
    """(V_residual / V0)^2: what a residual field holds, and it keeps its polarisation."""
    if phase == ENGAGING or p.residual_fraction == 0.0:
        return 0.0
    return p.residual_fraction * p.residual_fraction * math.exp(-2.0 * t / p.residual_decay_time)


@inlined
def full_amount(p, phase):
    """F_ea's scale [N m2] at the edge: the film is released from what the hold has left."""
    full = p.force_scale * p.voltage * p.voltage
    return full * p.held_factor if phase == RELEASING else full


@inlined
def fields_at(p, t, phase, tables):
    """(field of the drive, residual field) at t."""
    full = full_amount(p, phase)
    ratio, _, kappa, _ = history(p, t, phase, tables)
    left = residual_left(p, t, phase)
    main = make_field(p, full * ratio, kappa, ratio + left) if ratio > SPENT else NO_FIELD
    rest = make_field(p, full * left, p.kappa_driven, ratio + left) if left > 0.0 else NO_FIELD
    return main, rest, left > 0.0


@inlined
def electroadhesion(p, fields, h, tables):
    """F_ea [N] of both fields at h."""
    force = field_force(p, fields[0], h, tables)
    if fields[2]:
        force += field_force(p, fields[1], h, tables)
    return force


@inlined
def electroadhesion_slopes(p, t, phase, h, tables):
    """(F_ea, dF_ea/dh, dF_ea/dt) at t."""
    full = full_amount(p, phase)
    ratio, ratio_rate, kappa, kappa_rate = history(p, t, phase, tables)
    left = residual_left(p, t, phase)
    force, slope, rate = 0.0, 0.0, 0.0
    if ratio > SPENT:
        field = make_field(p, full * ratio, kappa, ratio + left)
        film, thickness = field[3], field[2]
        force, slope, by_film, value = field_slopes(p, field, h, tables)
        film_rate = (
            -film * kappa_rate / kappa - film * p.thickness / thickness * p.thinning_ratio * ratio_rate
        )
        if p.saturation_ratio != 0.0:
            film_rate += (
                film * p.saturation_ratio * ratio_rate / (3.0 + 3.0 * p.saturation_ratio * (ratio + left))
            )
        rate = full * ratio_rate * value + by_film * film_rate
    if left > 0.0:
        field = make_field(p, full * left, p.kappa_driven, ratio + left)
        more, more_slope, _, _ = field_slopes(p, field, h, tables)
        force += more
        slope += more_slope
        rate -= 2.0 * more / p.residual_decay_time
    return force, slope, rate
