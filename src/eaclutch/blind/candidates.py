"""The sixteen named effects in this generator's own laws. ``size`` 1 is a magnitude the literature reports.

Each takes (runs, constants, size, rng) and returns changed (runs, constants); size 0 changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from eaclutch.blind.contact import rest_gap
from eaclutch.blind.world import Constants, Runs

Law = Callable[[Runs, Constants, float, np.random.Generator], tuple[Runs, Constants]]


def trapped_charge(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Homocharge that a slow drive injects and that drains by a power of time (Curie-von Schweidler)."""
    share = -0.95 * np.expm1(-1.1 * size * (1 + runs.frequency / 4.0) ** -0.7 * (runs.voltage / 300))
    return runs.turn(residual=share, residual_time=1.5e-3, residual_power=0.8), c


def edge_wrap(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Film bent round both edges: a side wall that grows like a Hertzian foot, pulled on by the voltage."""
    foot = size * (runs.preload / 0.5) ** (2 / 3) * (runs.thickness / 2e-3) ** 0.5
    return runs.turn(side_force=0.025 * foot, side_voltage_gain=3.0 / 300**2, side_damping=0.12 * foot), c


def permittivity_saturation(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """Dipoles turn into the field by Langevin's law: kappa falls as 3 (coth x - 1/x) / x."""
    x = np.maximum(size * 1.1 * runs.voltage / 300, 1e-4)
    fall = np.where(x < 1e-2, 1 - x**2 / 15, 3 * (1 / np.tanh(x) - 1 / x) / x)
    return replace(runs, kappa=c.kappa_infinity + (runs.kappa - c.kappa_infinity) * fall), c


def electrostriction(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """Maxwell and electrostrictive squeeze of an incompressible film: finite strain, ln T falls as E^2."""
    strain = 0.08 * size * (runs.voltage / 300) ** 2
    return replace(runs, film_thickness=runs.film_thickness * np.exp(-strain)), c


def series_compliance(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """The film in shear (softer the narrower the strip) and the mount, behind the load cell."""
    shear = 0.3 * (2e-3 / runs.width) * (c.overlap_length / 55.5e-3)
    return runs.turn(compliance=size * (shear + 0.08) / c.stiffness), c


def substrate_inertia(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """A share of the substrate (and of its clamp) rides with the tip; size 1: a quarter of its mass."""
    return runs.turn(moving_mass=0.25 * size * runs.substrate_weight(c) / 9.81), c


def stray_capacitance(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """Leads and fringe in parallel with the pad on the capacitance bench."""
    return runs, replace(c, stray_capacitance=c.stray_capacitance + 3e-12 * size)


def trigger_latency(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """The film's edge comes after the logged one; each run jitters by a tenth."""
    delay = 100e-6 * size * (1 + 0.1 * rng.standard_normal(len(runs)))
    return runs.turn(delay_on=np.abs(delay), delay_off=np.abs(delay)), c


def slow_drive(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """The discharge is limited in current, so that wide pads at high voltage take longest."""
    return runs.turn(slew_current=np.full(len(runs), 5e-5 / max(size, 1e-6))), c


def gap_tilt(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """A wedge across the width: each of four strips stands at its own height."""
    return runs.turn(wedge_half_height=1.5e-6 * size * (runs.width / 2e-3) ** 0.5), c


def surface_adhesion(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """Attraction without voltage, an exponential well in the mean gap."""
    depth = 1.2 * size * runs.width / 2e-3
    return runs.turn(adhesion_force=depth, adhesion_range=2.2e-6), c


def contact_aging(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Static friction grows as a power of the time at rest."""
    return runs.turn(aging_depth=0.3 * size), c


def velocity_weakening(
    runs: Runs, c: Constants, size: float, rng: np.random.Generator
) -> tuple[Runs, Constants]:
    """Kinetic friction falls hyperbolically with speed."""
    return runs.turn(weakening_depth=min(0.12 * size, 0.95), weakening_speed=6e-3), c


def gas_slip(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Veijola's effective viscosity; size 1: a mean free path of 2 um (air leaking through the roughness)."""
    return runs.turn(mean_free_path=2e-6 * size), c


def film_tension(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """A clamped film that stiffens as it is drawn down, and holds a part of the preload off."""
    rest, _ = rest_gap(runs, c, np.zeros(len(runs)), runs.kappa)
    stiff = 0.4e5 * size * (runs.width / 2e-3) ** 0.5
    return runs.turn(film_spring=stiff, film_hardening=stiff / (3e-6) ** 2, film_rest_gap=rest), c


def session_drift(runs: Runs, c: Constants, size: float, rng: np.random.Generator) -> tuple[Runs, Constants]:
    """Mounting and humidity: each session scales the pull and the film's friction in its own way."""
    sessions = runs.session.astype(int)
    pattern = rng.permutation([-1.0, 0.1, 0.9])
    pull = np.exp(0.15 * size * pattern)[sessions]
    rub = np.exp(0.04 * size * rng.permutation([-1.0, 0.1, 0.9]))[sessions]
    runs = replace(runs, film_static=runs.film_static * rub, film_kinetic=runs.film_kinetic * rub)
    return runs.turn(force_factor=runs.knob("force_factor", 1.0) * pull), c


NAMED: dict[str, Law] = {
    law.__name__: law
    for law in (
        trapped_charge,
        edge_wrap,
        permittivity_saturation,
        electrostriction,
        series_compliance,
        substrate_inertia,
        stray_capacitance,
        trigger_latency,
        slow_drive,
        gap_tilt,
        surface_adhesion,
        contact_aging,
        velocity_weakening,
        gas_slip,
        film_tension,
        session_drift,
    )
}
