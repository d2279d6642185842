"""Forces across the gap: asperity contact, the voltage's pull averaged over a rough gap, and their balance."""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import gamma, pbdv

from eaclutch.blind.world import CUT, VACUUM_PERMITTIVITY, Constants, Runs
from eaclutch.records import FloatArray

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(14)
_WEDGE, _WEDGE_WEIGHTS = np.polynomial.legendre.leggauss(4)


@lru_cache(maxsize=1)
def _log_load() -> CubicSpline:
    """ln G on x in [-6, 14], from Whittaker's function: G = Gamma(5/2) exp(-x^2/4) D_{-5/2}(x) / sqrt(2 pi)."""
    x = np.linspace(-6, 14, 801)
    cylinder = pbdv(-2.5, x)[0]
    return CubicSpline(x, np.log(gamma(2.5) / np.sqrt(2 * np.pi) * cylinder) - x**2 / 4)


def asperity_load(x: FloatArray) -> FloatArray:
    """G(x), the Greenwood-Williamson load integral of spherical asperities (DOI 10.1098/rspa.1966.0242)."""
    return np.exp(_log_load()(np.clip(x, -6, 14)))


def contact_shape(x: FloatArray, law: str, share: float) -> FloatArray:
    """Dimensionless load against x = h / sigma: asperities, with a share of another law that meets it at x = 2.

    ``exponential``: the limit of Persson's theory (DOI 10.1103/PhysRevLett.99.125502); ``fractal``: a power
    law of the separation (Majumdar-Bhushan like); both have the asperities' value and slope at x = 2.
    """
    load = asperity_load(x)
    if share == 0.0:
        return load
    reference, slope = np.exp(_log_load()(2.0)), float(_log_load()(2.0, 1))
    if law == "exponential":
        other = reference * np.exp(slope * (x - 2))
    elif law == "fractal":
        other = reference * (np.maximum(x, 0.25) / 2) ** (2 * slope)
    else:
        raise ValueError(f"no contact law {law!r}")
    return (1 - share) * load + share * other


def contact_force(gap: FloatArray, runs: Runs, c: Constants, length: float | None = None) -> FloatArray:
    """F_k [N] at mean gap h [m] (runs,): contact, grains of dust, a wedge averaged over four strips.

    ``length``: of the overlap, the pad's by default. Dust: springs of height ``dust_height``, Hertzian.
    """
    length = c.overlap_length if length is None else length
    scale = c.contact_stiffness * length * runs.width * c.roughness_sd**1.5 * runs.knob("contact_factor", 1.0)
    half = runs.knob("wedge_half_height")
    if np.any(half > 0):
        local = gap[:, None] + half[:, None] * _WEDGE
        shape = contact_shape(local / c.roughness_sd, c.law, c.law_share) @ _WEDGE_WEIGHTS / 2
    else:
        shape = contact_shape(gap / c.roughness_sd, c.law, c.law_share)
    dust = runs.knob("dust_stiffness") * np.maximum(runs.knob("dust_height") - gap, 0.0) ** 1.5
    return scale * shape + dust


def rough_average(gap: FloatArray, reach: FloatArray, sd: float) -> FloatArray:
    """Mean of 1 / (reach + tau)^2 over tau ~ Normal(gap, sd), tau > -CUT reach, not renormalised [m^-2].

    ``reach`` = T_d / kappa. With s = 1 / (reach + tau) the mean is the integral of the Gaussian over s, which
    panels that grow by a constant ratio resolve. Shapes (runs,).
    """
    gap, reach = np.broadcast_arrays(np.asarray(gap, float), np.asarray(reach, float))
    top = 1 / ((1 - CUT) * reach)
    middle = 1 / (reach + np.maximum(gap, 0))
    middle = np.minimum(middle, 0.5 * top)
    bottom = 1 / (reach + np.maximum(gap, 0) + 7 * sd)
    panels = np.stack(
        [bottom, (bottom * middle) ** 0.5, *(middle * (top / middle) ** (j / 4) for j in range(5))], axis=-1
    )
    low, high = panels[..., :-1, None], panels[..., 1:, None]
    s = (low + high) / 2 + (high - low) / 2 * _NODES
    density = np.exp(-0.5 * ((1 / s - (reach + gap)[..., None, None]) / sd) ** 2) / (sd * np.sqrt(2 * np.pi))
    return np.sum(density * _WEIGHTS * (high - low) / 2, axis=(-2, -1))


def electric_force(
    gap: FloatArray, voltage: FloatArray, kappa: FloatArray, runs: Runs, c: Constants
) -> FloatArray:
    """F_ea [N] of the comb at mean gap (runs,) for drive amplitude and permittivity at that instant."""
    reach = runs.film_thickness / kappa
    half = runs.knob("wedge_half_height")
    if np.any(half > 0):
        local = gap[:, None] + half[:, None] * _WEDGE
        mean = rough_average(local, reach[:, None], c.roughness_sd) @ _WEDGE_WEIGHTS / 2
    else:
        mean = rough_average(gap, reach, c.roughness_sd)
    factor = runs.knob("force_factor", 1.0)
    return factor * VACUUM_PERMITTIVITY * c.electrodes * runs.area(c) * (voltage / 2) ** 2 / 2 * mean


def held_apart(gap: FloatArray, runs: Runs, c: Constants) -> FloatArray:
    """Net force without voltage that opens the gap [N] (runs,): contact less weight, preload and adhesion.

    Adhesion: an exponential well of depth ``adhesion_force`` and range ``adhesion_range``; a stretched film
    carries ``film_spring`` y + ``film_hardening`` y^3 of the load, y being how far it was drawn down.
    """
    load = runs.preload * (1 - runs.knob("preload_carried")) + runs.film_weight(c)
    pull = runs.knob("adhesion_force") * np.exp(-np.maximum(gap, 0) / runs.knob("adhesion_range", 1e-6))
    drawn = np.maximum(runs.knob("film_rest_gap") - gap, 0.0)
    stretch = runs.knob("film_spring") * drawn + runs.knob("film_hardening") * drawn**3
    return contact_force(gap, runs, c) - load - pull + stretch


def rest_gap(
    runs: Runs, c: Constants, voltage: FloatArray, kappa: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Gap at rest [m] (runs,) under ``voltage``, coming from large gaps, and where the film pulled in (bool).

    Scan from the open side for the first change of sign, then bisection; a run without one has pulled in and
    stands at the scan's end.
    """
    grid = np.linspace(9 * c.roughness_sd, 0.15 * c.roughness_sd, 60)
    n = len(runs)

    def net(gap: FloatArray) -> FloatArray:
        force = held_apart(gap, runs, c)
        if np.any(voltage > 0):
            force = force - electric_force(gap, voltage, kappa, runs, c)
        return force

    low, high = np.full(n, grid[-1]), np.full(n, grid[0])
    found = np.zeros(n, bool)
    for open_side, closed_side in itertools.pairwise(grid):
        fresh = ~found & (net(np.full(n, closed_side)) >= 0)
        low[fresh], high[fresh] = closed_side, open_side
        found |= fresh
        if found.all():
            break
    for _ in range(34):
        middle = (low + high) / 2
        opens = net(middle) >= 0
        low, high = np.where(opens, middle, low), np.where(opens, high, middle)
    return np.where(found, (low + high) / 2, grid[-1]), ~found
