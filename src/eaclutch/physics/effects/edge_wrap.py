"""Edge wrap: the preload bends the compliant film round the substrate's edges, so that it rubs on the side
walls too. The touching width of a bent film is that of a line or of a rounded foot under load, which grows as the
preload to a power between 1/2 (Hertz's line) and 1; a film that first has to be bent as far as the walls touches
later, with a power above 1. So the normal force there is c P_ref (P / P_ref)^n. Where the pressure says how far the
film wraps, a wide strip's walls carry less of it, where the load on an edge does, as much: (w_ref / w)^q. While the
voltage is on, the electrodes that face the walls pull as well, by a Maxwell stress that grows as kappa V^2 across a
given gap, and faster where the pull closes the gap of a rough contact, as it does at the pad (there as its square,
nearly); preloads are small beside such pulls, so its size is its own. To these forces the friction is proportional
that the walls add beside base and film (static and kinetic, in the film's ratio), and without the voltage a viscous
damping of the sliding and a damping of the film's lift, for the air has to get round the edges, too. Side
friction is part of the friction before the voltage, from which the preload is known:
F_before = mu P + c_f P_ref (P / P_ref)^n + weights, with mu = mu_b + mu_d, so the preload solves
P + (c_f / mu) P_ref (P / P_ref)^n = P_0, what the base model makes of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import REFERENCE_VOLTAGE, Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

REFERENCE_PRELOAD = 0.5  # N
REFERENCE_WIDTH = 2e-3  # m, the rig's most usual strip
STEPS = 8  # of Newton in log P; the equation is convex there and its slope lies between 1 and n


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Side friction c_f P_ref (P / P_ref)^n with c_f = c (w_ref / w)^q (kinetic; static in the film's ratio), and
    g (kappa V^2 / (kappa_s V_0^2))^(m / 2) P_ref (P / P_ref)^n more with the voltage on; side damping
    c_d P_ref (P / P_ref)^n, and damping_factor + d N / P_ref with the walls' normal force N = that friction without
    the voltage / mu_d."""
    p = inputs.parameters
    narrower = REFERENCE_WIDTH / inputs.conditions.width
    coefficient = values["friction_per_preload"] * narrower ** np.asarray(values["width_exponent"])
    bare, factor = p["base_kinetic"] + p["film_kinetic"], np.asarray(sockets.friction_factor)
    exponent = np.asarray(values["preload_exponent"])
    # what the friction before says of the preload where all friction is ``factor`` times as large
    without = inputs.preload + inputs.conditions.friction_before * (1.0 / factor - 1.0) / bare
    preload = _pressed(without, coefficient / (factor * bare), exponent)
    foot = REFERENCE_PRELOAD * (preload / REFERENCE_PRELOAD) ** exponent
    kinetic = coefficient * foot
    kappa = np.asarray(sockets.kappa_driven)
    stress = np.where(np.isnan(kappa), 1.0, kappa / p["kappa_static"])
    stress = stress * (inputs.conditions.voltage / REFERENCE_VOLTAGE) ** 2
    pull = values["pull_per_preload"] * foot * stress ** (0.5 * np.asarray(values["voltage_exponent"]))
    return sockets.with_(
        side_friction=sockets.side_friction + kinetic,
        side_friction_static=sockets.side_friction_static + kinetic * p["film_static"] / p["film_kinetic"],
        side_pull=sockets.side_pull + pull,
        side_damping=sockets.side_damping + values["damping_per_preload"] * foot,
        damping_factor=sockets.damping_factor
        + values["squeeze_ratio"] * kinetic / (p["film_kinetic"] * REFERENCE_PRELOAD),
    )


def _pressed(without: FloatArray, ratio: FloatArray, exponent: FloatArray) -> FloatArray:
    """Preload [N] that solves P + ratio P_ref (P / P_ref)^n = ``without``; broadcasts."""
    given = np.maximum(without, 0.0) / REFERENCE_PRELOAD
    known = np.where(given > 0.0, given, 1.0)
    y = np.log(known) + np.zeros(np.broadcast_shapes(np.shape(known), np.shape(ratio), np.shape(exponent)))
    for _ in range(STEPS):
        flat, side = np.exp(y), ratio * np.exp(exponent * y)
        y = y - (np.log(flat + side) - np.log(known)) * (flat + side) / (flat + exponent * side)
    found: FloatArray = REFERENCE_PRELOAD * np.where(given > 0.0, np.exp(y), 0.0)
    return found


EFFECT = Effect(
    name="edge_wrap",
    role="candidate",
    stage="friction",
    action="adds",
    summary="preload bends the film round the edges: side friction and damping that grow with preload",
    parameters=(
        Parameter(
            "friction_per_preload",
            "1",
            (0.0, 3.0),
            0.0,
            Prior("halfnormal", 0.2),
            neutral=0.0,
            description="kinetic side-wall friction over preload, at 0.5 N and 2 mm without voltage",
        ),
        Parameter(
            "damping_per_preload",
            "kg/s/N",
            (0.0, 50.0),
            0.0,
            Prior("halfnormal", 2.0),
            neutral=0.0,
            description="viscous side-wall damping over preload, at 0.5 N",
        ),
        Parameter(
            "squeeze_ratio",
            "1",
            (0.0, 40.0),
            0.0,
            Prior("halfnormal", 3.0),
            description="damping of the film's lift over that of the air, where the walls are pressed with 0.5 N",
        ),
        Parameter(
            "preload_exponent",
            "1",
            (0.4, 2.5),
            1.0,
            Prior("normal", 1.0, 0.35),
            description="the side wall's force grows as the preload to this power",
        ),
        Parameter(
            "width_exponent",
            "1",
            (-0.5, 2.0),
            0.5,
            Prior("normal", 0.5, 0.5),
            description="and falls as the strip's width to this one",
        ),
        Parameter(
            "pull_per_preload",
            "1",
            (0.0, 5.0),
            0.0,
            Prior("halfnormal", 0.3),
            neutral=0.0,
            description="further kinetic side-wall friction at 300 V over preload, at 0.5 N",
        ),
        Parameter(
            "voltage_exponent",
            "1",
            (1.0, 6.0),
            2.0,
            Prior("normal", 3.0, 0.8),
            description="that grows as the voltage to this power, and as the permittivity to half of it",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (their "
        "conjecture for release slowing with preload); K. L. Johnson, Contact Mechanics (1985), ch. 4 (exponents); "
        "law derived here"
    ),
    validity="the film stays elastic; the walls are held less than the pad",
    apply=apply,
    draw=lambda rng: {
        "friction_per_preload": rng.uniform(0.05, 0.5),
        "damping_per_preload": rng.uniform(0.5, 6.0),
        "squeeze_ratio": rng.uniform(0.0, 1.5),
        "preload_exponent": rng.uniform(0.6, 1.6),
        "width_exponent": rng.uniform(0.0, 1.0),
        "pull_per_preload": rng.uniform(0.0, 0.5),
        "voltage_exponent": rng.uniform(2.0, 3.5),
    },
)
