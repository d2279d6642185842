"""The base model's laws as pure functions (physics in docs/physics.md; Rauf & Follmer, doi:10.1016/j.eml.2025.102382).

These are the definitions: readable, exact, slow where an integral is needed. The compiled solver evaluates the
same laws through tables (``tables.py``), and the tests hold one against the other. All arguments broadcast.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.integrate import quad
from scipy.special import gamma, ndtr, pbdv

from eaclutch.records import FloatArray, Pad

Quantity = FloatArray | float

VACUUM_PERMITTIVITY = 8.8541878128e-12  # F/m
AIR_VISCOSITY = 1.85e-5  # Pa s
GRAVITY = 9.81  # m/s2
SHORTEST_EDGE = 1e-12  # s, a step


def force_scale(pad: Pad, width: Quantity) -> FloatArray:
    """Q [N m2 / V2] such that the flat-gap force is Q V^2 / (T_d / kappa + h)^2; ``width`` [m]."""
    width = np.asarray(width, dtype=float)
    if pad.type == "parallel_plate":
        return VACUUM_PERMITTIVITY * pad.overlap_length * width / 2
    return VACUUM_PERMITTIVITY * pad.electrodes * pad.electrode_length * width / 8


def capacitance_scale(pad: Pad, width: Quantity, overlap_length: float | None = None) -> FloatArray:
    """B [F m] such that C = B / (T_d / kappa + h). A comb is two half-combs in series (area / 4 in all);
    for a parallel plate the overlap is the pad's, or ``overlap_length`` [m] on the capacitance fixture."""
    width = np.asarray(width, dtype=float)
    if pad.type == "parallel_plate":
        length = pad.overlap_length if overlap_length is None else overlap_length
        return VACUUM_PERMITTIVITY * length * width
    return VACUUM_PERMITTIVITY * pad.electrodes * pad.electrode_length * width / 4


def capacitance(pad: Pad, width: Quantity, gap: Quantity, kappa: Quantity, thickness: Quantity) -> FloatArray:
    """Capacitance [F] of pad and strip at a mean gap [m] (paper eq. for C(T_air))."""
    return capacitance_scale(pad, width) / (np.asarray(thickness) / kappa + gap)


def mean_inverse_distance(film: Quantity, gap: Quantity, half_spread: Quantity) -> FloatArray:
    """Mean of 1 / (film + h) [1/m] over gaps h spread evenly by ``half_spread`` about ``gap``, ``film`` = T_d / kappa
    (all [m]); where the faces touch, h is 0."""
    film, gap, half = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (film, gap, half_spread)))
    spread = np.where(half > 0.0, half, 1.0)
    touching = np.maximum(spread - gap, 0.0)
    open_part = np.log((film + gap + spread) / (film + np.maximum(gap - spread, 0.0)))
    return np.where(half > 0.0, (open_part + touching / film) / (2.0 * spread), 1.0 / (film + gap))


def gap_from_capacitance(
    pad: Pad, width: Quantity, capacitance: Quantity, kappa: Quantity, thickness: Quantity
) -> FloatArray:
    """Mean gap [m] from a capacitance [F]; negative where the reading exceeds the bare film's."""
    return capacitance_scale(pad, width) / np.asarray(capacitance) - np.asarray(thickness) / kappa


def permittivity(
    frequency: Quantity, kappa_static: Quantity, kappa_infinity: Quantity, relaxation_time: Quantity,
    exponent: Quantity,
) -> FloatArray:  # fmt: skip
    """Real part of the Cole-Cole permittivity (Cole & Cole 1941, doi:10.1063/1.1750906) at ``frequency`` [Hz]."""
    spread = (2j * np.pi * np.asarray(frequency) * relaxation_time) ** exponent
    return kappa_infinity + (np.asarray(kappa_static) - kappa_infinity) * (1.0 / (1.0 + spread)).real


def kept_mean_square(time_constant: Quantity, half_period: Quantity) -> FloatArray:
    """Mean square of a voltage that follows a square wave with ``time_constant`` [s], over the wave's own:
    1 - tanh(x) / x with x = ``half_period`` / (2 time_constant); derived here."""
    x = np.asarray(half_period) / (2.0 * np.maximum(time_constant, SHORTEST_EDGE))
    return np.asarray(1.0 - np.tanh(x) / x)


def mittag_leffler(exponent: float, y: float) -> float:
    """E_alpha(-y^alpha) for 0 < alpha <= 1, y >= 0, by its spectral integral (Gorenflo & Mainardi 1997)."""
    if exponent == 1.0 or y == 0.0:
        return float(np.exp(-y))
    sine, cosine = np.sin(np.pi * exponent), np.cos(np.pi * exponent)

    def density(q: float) -> float:  # in q = log r^alpha
        return float(np.exp(-np.exp(min(q / exponent, 700.0)) * y) / (2 * (np.cosh(q) + cosine)))

    # the peak at q = 0 narrows as the exponent nears 1; the exponential cuts off at q = -alpha log y
    cut = -exponent * np.log(y)
    width = 1.0 - exponent
    edges = np.unique([*np.arange(-40.0, 41.0, 2.0), -width, width, *(cut + np.arange(-4.0, 5.0))])
    total = sum(quad(density, a, b, epsabs=1e-16, epsrel=1e-11, limit=200)[0] for a, b in pairwise(edges))
    return float(sine / (np.pi * exponent) * total)


def greenwood_williamson(x: Quantity) -> FloatArray:
    """G(x) = integral over s > x of (s - x)^1.5 phi(s) ds, through the parabolic cylinder function
    D_{-5/2} (DLMF 12.5.1): valid on both sides of x = 0, G(0) = 0.430 (Greenwood & Williamson 1966)."""
    x = np.asarray(x, dtype=float)
    return gamma(2.5) / np.sqrt(2 * np.pi) * np.exp(-x * x / 4) * pbdv(-2.5, x)[0]


# Where another contact law than this departs from it: about a gap of two roughnesses (log G and its slope there), in
# proportion to the e-folds of load from three of them on.
BEND_LOG_LOAD = float(np.log(greenwood_williamson(2.0)))
BEND_SLOPE = -float(pbdv(-1.5, 2.0)[0] / pbdv(-2.5, 2.0)[0])
BEND_REACH = 3.0


def bent(log_load: Quantity, bend: Quantity) -> FloatArray:
    """Log load of a surface whose heights are not Gaussian, from log G(x): it meets G at x = 2, value and slope, and
    its curvature in x is larger by ``bend`` there, by 0.80 for exponentially distributed heights (Greenwood &
    Williamson 1966, doi:10.1098/rspa.1966.0242). Form chosen here; it falls with the gap where |bend| < 2.6."""
    away = (np.asarray(log_load, dtype=float) - BEND_LOG_LOAD) / BEND_REACH
    return log_load + np.asarray(bend) * (BEND_REACH / BEND_SLOPE) ** 2 * (np.sqrt(1.0 + away**2) - 1.0)


def contact_force(
    gap: Quantity, stiffness: Quantity, roughness: Quantity, length: Quantity, width: Quantity,
    bend: Quantity = 0.0,
) -> FloatArray:  # fmt: skip
    """F_k [N] = k L w sigma^1.5 G(h / sigma), G ``bent`` where the heights are not Gaussian."""
    roughness = np.asarray(roughness, dtype=float)
    load = greenwood_williamson(gap / roughness)
    if np.any(bend):
        load = np.exp(bent(np.log(load), bend))
    return stiffness * np.asarray(length) * width * roughness**1.5 * load


def roughness_average(
    gap: float, film: float, roughness: float, cut: float = 0.83, rule: str = "published"
) -> float:
    """Average of (T_d / kappa + tau)^-2 [m^-2] over tau ~ Normal(h, sigma^2), by quadrature.

    ``film`` = T_d / kappa [m]. Rule ``published``: tau > -cut T_d / kappa, not renormalised; ``clamped``: the
    flat-gap kernel at max(tau, 0) over all tau. Integrated in log(T_d / kappa + tau): the kernel is steep at the cut.
    """
    low = film * (1.0 if rule == "clamped" else 1.0 - cut)

    def integrand(u: float) -> float:
        s = np.exp(u)
        return float(np.exp(-0.5 * ((s - film - gap) / roughness) ** 2) / s)

    high = max(film + gap, low) + 12 * roughness
    centre = min(max(film + gap, 1.0001 * low), 0.999 * high)
    edges = np.unique(np.log([low, np.sqrt(low * centre), centre, np.sqrt(centre * high), high]))
    total = sum(quad(integrand, a, b, epsabs=0, epsrel=1e-12, limit=400)[0] for a, b in pairwise(edges))
    average = total / (roughness * np.sqrt(2 * np.pi))
    if rule == "clamped":
        average += float(ndtr(-gap / roughness)) / film**2
    return float(average)


def squeeze_film_coefficient(length: Quantity, width: Quantity) -> FloatArray:
    """c [N s m2] such that F_b = -c / h^3 dh/dt (Griffin et al., J. Basic Eng. 88 (1966) 451)."""
    short, long = np.minimum(length, width), np.maximum(length, width)
    return 96 * AIR_VISCOSITY * short**3 * long / np.pi**4


def base_preload(
    friction_before: Quantity, film_kinetic: Quantity, base_kinetic: Quantity, substrate_mass: Quantity,
    film_mass: Quantity,
) -> FloatArray:  # fmt: skip
    """F_pre [N] from the friction before the voltage (paper eq. for F_preload); may come out negative."""
    weight = GRAVITY * (np.asarray(base_kinetic) * substrate_mass + np.asarray(film_kinetic) * film_mass)
    return (friction_before - weight) / (np.asarray(film_kinetic) + base_kinetic)


def slip_overshoot(stiffness: Quantity, mass: Quantity, damping: Quantity) -> FloatArray:
    """Share rho by which a slip overshoots: F_min = F_kin - rho (F_stat - F_kin), with rho = exp(-pi z / sqrt(1 - z^2))
    and the load cell's damping ratio z = b / (2 sqrt(k m)); 0 where it does not swing."""
    ratio = np.minimum(np.asarray(damping) / (2.0 * np.sqrt(np.asarray(stiffness) * mass)), 1.0 - 1e-12)
    return np.asarray(np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2)))


def larger_slip(fraction: Quantity, excess: Quantity, overshoot: Quantity) -> FloatArray:
    """Fraction of the force that a slip lets go whose static capacity lies by ``excess`` (a share of it) above that of
    a slip that lets go ``fraction``. The kinetic friction is the same: it also falls deeper, by rho ``excess``."""
    excess = np.asarray(excess)
    return np.asarray((fraction + excess * (1.0 + overshoot)) / (1.0 + excess))
