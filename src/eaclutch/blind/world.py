"""One sealed world: the true constants of a bench and the state of every run that is made on it.

Nothing here is shared with the library's laws: the arrays below are this generator's own knobs.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from eaclutch.records import FloatArray

GRAVITY = 9.81  # m/s2
VACUUM_PERMITTIVITY = 8.8541878128e-12  # F/m
AIR_VISCOSITY = 1.85e-5  # Pa s
CUT = 0.83  # lower end of the gap average, as a share of T_d / kappa (published rule)


@dataclass(frozen=True)
class Constants:
    """True constants of one bench, drawn once a case (scalars, SI). Sources: paper Tables 1-2, S2."""

    contact_stiffness: float  # N m^-3.5
    roughness_sd: float  # m
    film_thickness: float  # m
    kappa_static: float
    kappa_infinity: float
    relaxation_time: float  # s
    cole_cole_exponent: float
    stiffness: float  # N/m
    mass: float  # kg
    damping: float  # kg/s
    base_static: float
    base_kinetic: float
    film_static: float
    film_kinetic: float
    rise_10_90: float = 8.3e-6  # s
    fall_90_10: float = 5.2e-6  # s
    electrodes: int = 28
    electrode_length: float = 1.5e-3  # m
    overlap_length: float = 55.5e-3  # m
    fixture_length: float = 60e-3  # m
    meter_frequency: float = 1000.0  # Hz
    film_density: float = 1780.0  # kg/m3
    substrate_density: float = 8338.5  # kg/m3
    substrate_extra_mass: float = 0.000726  # kg
    substrate_length: float = 0.1  # m
    stage_speed: float = 0.5e-3  # m/s
    static_scatter: float = 0.02  # from slip to slip, relative
    stray_capacitance: float = 0.0  # F, on the capacitance bench, beyond the declared
    law: str = "asperities"  # other contact law mixed in
    law_share: float = 0.0


def draw_constants(rng: np.random.Generator) -> Constants:
    """A bench around the published one; each constant within its stated uncertainty.

    Contact stiffness and roughness lie on the ridge that the paper's two fits span (5.4e14 at 2.80 um to
    2.09e15 at 2.37 um), with a scatter across it.
    """
    sd = float(np.clip(rng.normal(2.75, 0.15), 2.4, 3.1))
    log_k = np.log(5.4e14) + np.log(2.09 / 0.54) / 0.43 * (2.80 - sd) + rng.normal(0, 0.12)
    return Constants(
        contact_stiffness=float(np.exp(log_k)),
        roughness_sd=sd * 1e-6,
        film_thickness=float(rng.normal(24e-6, 0.6e-6)),
        kappa_static=float(rng.normal(53.8, 1.0)),
        kappa_infinity=float(rng.normal(4.2, 0.4)),
        relaxation_time=float(rng.lognormal(np.log(2.75e-6), 0.08)),
        cole_cole_exponent=float(rng.normal(0.57, 0.012)),
        stiffness=float(rng.normal(18018, 400)),
        mass=float(rng.normal(0.0011004, 0.00004)),
        damping=float(rng.normal(0.4274, 0.04)),
        base_static=float(np.clip(rng.normal(0.281, 0.026), 0.215, 0.35)),
        base_kinetic=float(rng.normal(0.173, 0.006)),
        film_static=float(np.clip(rng.normal(0.188, 0.008), 0.17, 0.21)),
        film_kinetic=float(np.clip(rng.normal(0.154, 0.006), 0.138, 0.166)),
        static_scatter=float(rng.uniform(0.008, 0.022)),
        stray_capacitance=float(rng.normal(0.0, 0.5e-12)),
    )


def real_permittivity(
    frequency: FloatArray, static: float, infinity: float, time: float, exponent: float
) -> FloatArray:
    """Real part of Cole and Cole's formula (DOI 10.1063/1.1750906) at ``frequency`` [Hz], same shape."""
    z = (2j * np.pi * np.asarray(frequency, float) * time) ** exponent
    return infinity + (static - infinity) * np.real(1.0 / (1.0 + z))


@dataclass(frozen=True)
class Runs:
    """State of every run, shape (runs,), SI; the effects return changed copies.

    The defaults of the knobs are exactly neutral. ``gap_ripple`` adds nodes of a wedge in units of its half
    height; ``field_ratio`` is E over the saturation field; ``residual`` is a share of V.
    """

    voltage: FloatArray
    frequency: FloatArray
    width: FloatArray
    thickness: FloatArray
    preload: FloatArray  # N, true
    drive_time: FloatArray  # s, voltage on to off
    dwell: FloatArray  # s, the stage already rests
    order: FloatArray  # place in its session, 0..
    session: FloatArray  # index
    kappa: FloatArray
    film_thickness: FloatArray
    base_static: FloatArray
    base_kinetic: FloatArray
    film_static: FloatArray
    film_kinetic: FloatArray
    knobs: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.voltage)

    def knob(self, name: str, neutral: float = 0.0) -> FloatArray:
        """The knob ``name`` (runs,), or its neutral value when no effect has touched it."""
        return np.broadcast_to(np.asarray(self.knobs.get(name, neutral), float), (len(self),))

    def turn(self, **knobs: Any) -> Runs:
        """A copy with knobs set."""
        return replace(self, knobs=self.knobs | knobs)

    def substrate_weight(self, c: Constants) -> FloatArray:
        """m_s g [N] (runs,)."""
        mass = c.substrate_density * c.substrate_length * self.width * self.thickness + c.substrate_extra_mass
        return mass * GRAVITY

    def film_weight(self, c: Constants) -> FloatArray:
        """m_d g [N] of the film above the overlap (runs,)."""
        return c.film_density * c.overlap_length * self.width * self.film_thickness * GRAVITY

    def area(self, c: Constants) -> FloatArray:
        """Electrode area facing the substrate, one electrode [m2] (runs,)."""
        return c.electrode_length * self.width * self.knob("area_factor", 1.0)
