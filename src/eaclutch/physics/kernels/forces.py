"""Forces on the film at a gap h: contact, electroadhesion with its drive and dielectric history, adhesion."""

from __future__ import annotations

import math

from numba import njit

from eaclutch.physics.kernels.lookup import log_contact, relaxation, rough_kernel

RELEASING, ENGAGING = 0, 1
SMALLEST_GAP = 1e-10  # m; keeps the squeeze film finite while a trial step overshoots


@njit(cache=True, inline="always")
def contact(p, h, tables):
    """(F_k, dF_k/dh) [N, N/m]."""
    log_g, slope = log_contact(h / p.sigma, tables.contact)
    force = p.contact_scale * math.exp(log_g)
    return force, force * slope / p.sigma


@njit(cache=True, inline="always")
def adhesion(p, h):
    """(attraction without voltage, its derivative) [N, N/m]: A Phi(-h / sigma)."""
    if p.adhesion_force == 0.0:
        return 0.0, 0.0
    x = h / p.sigma
    density = math.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)
    return p.adhesion_force * 0.5 * math.erfc(x / math.sqrt(2.0)), -p.adhesion_force * density / p.sigma


@njit(cache=True)
def inverse_square(p, h, kappa, thickness, tables):
    """(I, dI/dh, dI/d film) with F_ea = Q V^2 I and film = thickness / kappa; the roughness rule of the row."""
    film = thickness / kappa
    value, slope_h, slope_film = 0.0, 0.0, 0.0
    rough = p.gap_in_force * p.roughness_in_force
    flat = p.gap_in_force - rough
    if flat != 0.0:
        y = 1.0 / (film + max(h, SMALLEST_GAP - 0.9 * film))
        value += flat * y * y
        slope_h -= 2.0 * flat * y * y * y
        slope_film -= 2.0 * flat * y * y * y
    if rough != 0.0:
        cut = 0.0 if p.clamped else p.cut
        keep = 1.0 - cut
        j, j_a, j_u = rough_kernel(keep * film / p.sigma, (h + cut * film) / p.sigma, tables.roughness)
        scale = rough / (p.sigma * p.sigma)
        value += scale * j
        slope_h += scale * j_u / p.sigma
        slope_film += scale * (keep * j_a + cut * j_u) / p.sigma
        if p.clamped:
            x = h / p.sigma
            below = 0.5 * math.erfc(x / math.sqrt(2.0)) / (film * film)
            value += rough * below
            slope_h -= rough * math.exp(-0.5 * x * x) / (math.sqrt(2.0 * math.pi) * p.sigma * film * film)
            slope_film -= 2.0 * rough * below / film
    bare = 1.0 - p.gap_in_force
    if bare != 0.0:
        value += bare / (film * thickness)
        slope_film -= bare / (film * film * thickness)
    return value, slope_h, slope_film


@njit(cache=True, inline="always")
def field_state(p, kappa, ratio):
    """(kappa, thickness) at the fraction ``ratio`` = (V / V0)^2 of the drive: saturation and electrostriction."""
    if p.saturation_ratio != 0.0:
        kappa *= (1.0 + p.saturation_ratio * ratio) ** (-1.0 / 3.0)
    return kappa, p.thickness * (1.0 - p.thinning_ratio * ratio)


@njit(cache=True)
def driven_force(p, h, tables):
    """(F_ea, dF_ea/dh) with the full voltage on for long."""
    if p.voltage == 0.0:
        return 0.0, 0.0
    kappa, thickness = field_state(p, p.kappa_driven, 1.0)
    value, slope, _ = inverse_square(p, h, kappa, thickness, tables)
    scale = p.force_scale * p.voltage * p.voltage
    return scale * value, scale * slope


@njit(cache=True)
def drive_history(p, t, phase, tables):
    """((V/V0)^2, its rate, kappa, its rate) at t after an edge: Cole-Cole step response, continuous at t = 0."""
    time_constant = p.fall_time_constant if phase == RELEASING else p.rise_time_constant
    decay = math.exp(-t / time_constant) if time_constant > 0.0 else 0.0
    rate = decay / time_constant if time_constant > 0.0 else 0.0
    if phase == RELEASING:
        kept = 1.0 - p.residual_fraction * p.residual_fraction
        ratio, ratio_rate = kept * decay * decay, -2.0 * kept * decay * rate
    else:
        ratio, ratio_rate = (1.0 - decay) ** 2, 2.0 * (1.0 - decay) * rate
    kappa, kappa_rate = p.kappa_driven, 0.0
    if p.relaxing != 0.0 and ratio > 0.0:
        left, slope = relaxation(p.exponent, t / p.relaxation_time, tables.relaxation)
        if phase == ENGAGING:
            left, slope = 1.0 - left, -slope
        span = p.relaxing * (p.kappa_driven - p.kappa_infinity)
        kappa = p.kappa_driven - span * (1.0 - left)
        kappa_rate = span * slope / t if t > 0.0 else 0.0
    return ratio, ratio_rate, kappa, kappa_rate


@njit(cache=True)
def electroadhesion(p, h, t, phase, tables):
    """(F_ea, dF_ea/dh, dF_ea/dt) at t after an edge. What a residual field holds keeps its polarisation."""
    if p.voltage == 0.0:
        return 0.0, 0.0, 0.0
    scale = p.force_scale * p.voltage * p.voltage
    force, slope, rate = 0.0, 0.0, 0.0
    ratio, ratio_rate, kappa, kappa_rate = drive_history(p, t, phase, tables)
    left = 0.0
    if phase == RELEASING and p.residual_fraction != 0.0:
        left = p.residual_fraction * p.residual_fraction * math.exp(-2.0 * t / p.residual_decay_time)
    if ratio > 1e-16:
        kappa_now, thickness = field_state(p, kappa, ratio + left)
        value, value_h, value_film = inverse_square(p, h, kappa_now, thickness, tables)
        film = thickness / kappa_now
        film_rate = -film * kappa_rate / kappa
        if p.saturation_ratio != 0.0:
            film_rate += (
                film * p.saturation_ratio * ratio_rate / (3.0 * (1.0 + p.saturation_ratio * (ratio + left)))
            )
        film_rate -= p.thickness * p.thinning_ratio * ratio_rate / kappa_now
        force = scale * ratio * value
        slope = scale * ratio * value_h
        rate = scale * (ratio_rate * value + ratio * value_film * film_rate)
    if left > 0.0:
        kappa_now, thickness = field_state(p, p.kappa_driven, ratio + left)
        value, value_h, _ = inverse_square(p, h, kappa_now, thickness, tables)
        force += scale * left * value
        slope += scale * left * value_h
        rate -= 2.0 * scale * left * value / p.residual_decay_time
    return force, slope, rate


@njit(cache=True, inline="always")
def squeeze(p, h):
    """(c(h), dc/dh) with F_b = -c dh/dt; c = damping / (h^2 (h + 6 slip_length))."""
    h = max(h, SMALLEST_GAP)
    wide = h + 6.0 * p.slip_length
    c = p.damping / (h * h * wide)
    return c, -c * (2.0 / h + 1.0 / wide)
