"""Forces on the film at a gap h: its tension, squeezed air, electroadhesion of a field; contact.py has the others.

A field is (amount, kappa, thickness, film, a, row, coordinate): F_ea = amount x I(h), amount = Q V^2, film =
thickness / kappa, and the place of the cut a in the roughness table; it does not depend on h, so the stages of a
step that share a time share it.

Where film and strip are not parallel, each force is the mean over gaps spread about h (``contact.half_spread``).
"""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import inlined
from eaclutch.physics.kernels.contact import PLACES, ROOT_HALF, ROOT_TWO_PI, SHARES, half_spread
from eaclutch.physics.kernels.lookup import rough_row, rough_slopes, rough_value

SMALLEST_GAP = 1e-10  # m; keeps the squeeze film finite while a trial step overshoots


@inlined
def tension(p, gap_before, h):
    """(force of the film drawn down from ``gap_before`` to ``h`` [m], its derivative by the way down) [N, N/m]; a film
    whose free gap is wider was drawn before, and has hardened."""
    before = max(p.film_free_gap - gap_before, 0.0)
    drawn = before + gap_before - h
    hard, hard_before = p.film_hardening * drawn * drawn, p.film_hardening * before * before
    force = p.film_spring * (drawn * (1.0 + hard) - before * (1.0 + hard_before))
    return force, p.film_spring * (1.0 + 3.0 * hard)


@inlined
def squeeze(p, h, tables):
    """(c(h), dc/dh) with F_b = -c dh/dt; c = damping / (h^2 (h + 6 slip_length)), and over gaps that spread by S times
    1 + 2 a (S / h)^2: the mean of 1/h^3 to the second order, of the share a that the air sees."""
    h = max(h, SMALLEST_GAP)
    inverse, wide = 1.0 / h, 1.0 / (h + 6.0 * p.slip_length)
    c = p.damping * inverse * inverse * wide
    slope = -c * (2.0 * inverse + wide)
    if p.gap_half_spread != 0.0 and p.gap_in_air != 0.0:
        spread, widening = half_spread(p, h, tables)
        part = spread * inverse
        if part < 1.0:
            more = 1.0 + 2.0 * p.gap_in_air * part * part
            slope = slope * more + c * 4.0 * p.gap_in_air * part * (widening - part) * inverse
        else:  # the faces touch: what is squeezed there hardly matters
            more = 1.0 + 2.0 * p.gap_in_air
            slope *= more
        c *= more
    return c, slope


@inlined
def make_field(p, amount, kappa, ratio):
    """The field [see module] at permittivity ``kappa`` before saturation and the fraction ``ratio`` = (V / V0)^2
    of the full drive, which saturates the film and thins it."""
    if p.saturation_ratio != 0.0:
        kappa *= (1.0 + p.saturation_ratio * ratio) ** (-1.0 / 3.0)
    thickness = p.thickness * (1.0 - p.thinning_ratio * ratio)
    film = thickness / kappa
    cut = 0.0 if p.clamped != 0.0 else p.cut
    a = (1.0 - cut) * film * p.inverse_sigma
    row, coordinate = rough_row(a)
    return amount, kappa, thickness, film, a, row, coordinate


@inlined
def field_force(p, field, h, tables):
    """F_ea [N] at h."""
    if field[0] == 0.0:
        return 0.0
    if p.gap_half_spread == 0.0:
        return level_field_force(p, field, h, tables)
    spread, _ = half_spread(p, h, tables)
    force = 0.0
    for i in range(len(PLACES)):
        force += SHARES[i] * level_field_force(p, field, h + PLACES[i] * spread, tables)
    return force


@inlined
def level_field_force(p, field, h, tables):
    """The same of a gap that is h everywhere."""
    amount, _, thickness, film, a, row, coordinate = field
    value = 0.0
    rough = p.gap_in_force * p.roughness_in_force
    if rough != 0.0:
        cut = 0.0 if p.clamped != 0.0 else p.cut
        j = rough_value(a, row, coordinate, (h + cut * film) * p.inverse_sigma, tables.roughness)
        value = rough * j * p.inverse_sigma * p.inverse_sigma
        if p.clamped != 0.0:
            value += rough * 0.5 * math.erfc(h * p.inverse_sigma * ROOT_HALF) / (film * film)
    if rough != 1.0:
        y = 1.0 / (film + max(h, -0.9 * film))
        value += (p.gap_in_force - rough) * y * y + (1.0 - p.gap_in_force) / (film * thickness)
    return amount * value


@inlined
def field_slopes(p, field, h, tables):
    """(F_ea, dF_ea/dh, dF_ea/d film, F_ea / amount)."""
    if field[0] == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    if p.gap_half_spread == 0.0:
        return level_field_slopes(p, field, h, tables)
    spread, widening = half_spread(p, h, tables)
    force, slope_h, slope_film, value = 0.0, 0.0, 0.0, 0.0
    for i in range(len(PLACES)):
        local = level_field_slopes(p, field, h + PLACES[i] * spread, tables)
        force += SHARES[i] * local[0]
        slope_h += SHARES[i] * local[1] * (1.0 + PLACES[i] * widening)
        slope_film += SHARES[i] * local[2]
        value += SHARES[i] * local[3]
    return force, slope_h, slope_film, value


@inlined
def level_field_slopes(p, field, h, tables):
    """The same of a gap that is h everywhere."""
    amount, _, thickness, film, a, row, coordinate = field
    value, slope_h, slope_film = 0.0, 0.0, 0.0
    rough = p.gap_in_force * p.roughness_in_force
    if rough != 0.0:
        cut = 0.0 if p.clamped != 0.0 else p.cut
        u = (h + cut * film) * p.inverse_sigma
        j, j_a, j_u = rough_slopes(a, row, coordinate, u, tables.roughness)
        scale = rough * p.inverse_sigma * p.inverse_sigma
        value = scale * j
        slope_h = scale * j_u * p.inverse_sigma
        slope_film = scale * ((1.0 - cut) * j_a + cut * j_u) * p.inverse_sigma
        if p.clamped != 0.0:
            x = h * p.inverse_sigma
            below = rough * 0.5 * math.erfc(x * ROOT_HALF) / (film * film)
            value += below
            slope_h -= rough * math.exp(-0.5 * x * x) / ROOT_TWO_PI * p.inverse_sigma / (film * film)
            slope_film -= 2.0 * below / film
    if rough != 1.0:
        y = 1.0 / (film + max(h, -0.9 * film))
        flat, bare = p.gap_in_force - rough, (1.0 - p.gap_in_force) / (film * thickness)
        value += flat * y * y + bare
        slope_h -= 2.0 * flat * y * y * y
        slope_film -= 2.0 * flat * y * y * y + bare / film
    return amount * value, amount * slope_h, amount * slope_film, value


@inlined
def driven_field(p):
    """The field with the full voltage on for long."""
    return make_field(p, p.force_scale * p.voltage * p.voltage, p.kappa_driven, 1.0)


@inlined
def held_field(p):
    """What is left of it at the end of the hold."""
    return make_field(p, p.held_factor * p.force_scale * p.voltage * p.voltage, p.kappa_driven, 1.0)
