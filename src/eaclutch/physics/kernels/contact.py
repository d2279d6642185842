"""What the faces do to each other at a gap h whether or not there is a voltage: contact, and adhesion without one.

Where film and strip are not parallel, each force is the mean over gaps spread evenly about h, of a half spread that
becomes smaller the closer the strip is brought, which turns it level.
"""

from __future__ import annotations

import math

import numpy as np

from eaclutch.physics.kernels.compiled import inlined
from eaclutch.physics.kernels.lookup import log_contact
from eaclutch.physics.laws import BEND_LOG_LOAD, BEND_REACH, BEND_SLOPE

ROOT_HALF = math.sqrt(0.5)
ROOT_TWO_PI = math.sqrt(2.0 * math.pi)
# Gauss-Legendre over the even spread: gaps at rest to 0.1 % for half spreads of up to 2.2 roughnesses.
PLACES, _WEIGHTS = (tuple(map(float, part)) for part in np.polynomial.legendre.leggauss(4))
SHARES = tuple(0.5 * weight for weight in _WEIGHTS)


@inlined
def half_spread(p, h, tables):
    """(half spread of the gaps about h, its derivative) [m, 1]: S / (1 + l F), F the contact of parallel faces."""
    if p.gap_levelling == 0.0:
        return p.gap_half_spread, 0.0
    load, slope = level_contact(p, h, tables)
    left = 1.0 / (1.0 + p.gap_levelling * load)
    spread = p.gap_half_spread * left
    return spread, -spread * left * p.gap_levelling * slope


@inlined
def contact(p, h, tables):
    """(F_k, dF_k/dh) [N, N/m]."""
    if p.gap_half_spread == 0.0:
        return level_contact(p, h, tables)
    spread, widening = half_spread(p, h, tables)
    force, slope = 0.0, 0.0
    for i in range(len(PLACES)):
        local, local_slope = level_contact(p, h + PLACES[i] * spread, tables)
        force += SHARES[i] * local
        slope += SHARES[i] * local_slope * (1.0 + PLACES[i] * widening)
    return force, slope


@inlined
def level_contact(p, h, tables):
    """The same of a gap that is h everywhere."""
    log_g, slope = log_load(p, h * p.inverse_sigma, tables)
    force = p.contact_scale * math.exp(log_g)
    return force, force * slope * p.inverse_sigma


@inlined
def log_load(p, x, tables):
    """(log of the dimensionless load at x = h / sigma, its slope): ``laws.bent`` of log G(x)."""
    log_g, slope = log_contact(x, tables.contact)
    if p.contact_law_bend == 0.0:
        return log_g, slope
    away = (log_g - BEND_LOG_LOAD) / BEND_REACH
    root = math.sqrt(1.0 + away * away)
    bend = p.contact_law_bend * BEND_REACH / BEND_SLOPE**2
    return log_g + bend * BEND_REACH * (root - 1.0), slope * (1.0 + bend * away / root)


@inlined
def adhesion(p, h, tables):
    """(attraction without voltage, its derivative) [N, N/m]: A Phi(-h / (r sigma)), r = range."""
    if p.adhesion_force == 0.0:
        return 0.0, 0.0
    if p.gap_half_spread == 0.0:
        return level_adhesion(p, h)
    spread, widening = half_spread(p, h, tables)
    force, slope = 0.0, 0.0
    for i in range(len(PLACES)):
        local, local_slope = level_adhesion(p, h + PLACES[i] * spread)
        force += SHARES[i] * local
        slope += SHARES[i] * local_slope * (1.0 + PLACES[i] * widening)
    return force, slope


@inlined
def level_adhesion(p, h):
    """The same of a gap that is h everywhere."""
    x = h * p.inverse_sigma / p.adhesion_range
    density = math.exp(-0.5 * x * x) / ROOT_TWO_PI
    slope = -p.adhesion_force * density * p.inverse_sigma / p.adhesion_range
    return p.adhesion_force * 0.5 * math.erfc(x * ROOT_HALF), slope
