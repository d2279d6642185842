"""Surface adhesion (DMT): forces that act outside the contacting spots load them, voltage or not. The share of a
Gaussian surface at or below zero gap is Phi(-h / sigma), so where the attraction ends with the contact the load is
p_a L_s w_s Phi(-h / sigma), and p_a its pressure in the spots that touch. One that reaches across the gap (left
charge, a film of water; van der Waals forces by themselves fade within 0.1 um or so) falls with the distance more
slowly than the share that touches. Its load is taken as p L_s w_s Phi(-h / (r sigma)), the same shape r times as
wide, with p = p_a Phi(-2) / Phi(-2 / r): at two spreads, where a lightly pressed film lies, it pulls as hard
whatever its range, so that p_a says how strong it is and r how it falls. That is no law of any one force: it has a
range and two ends, contact alone at r = 1 and, for a range far beyond the gap, a pressure of p / 2 that hardly
depends on it. Faces that were pressed together part with a stronger pull than they met with (adhesion hysteresis,
which JKR's spots have): from switch-off on it is a ratio as strong. The capacitance fixture, whose strip has neither
slid nor been charged, has an unknown share of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import ndtr

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior, fixture_share
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

LIGHT = 2.0  # spreads of the gap between a lightly pressed film and the substrate


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """adhesion_force = p L_s w_s at full contact, a share of it on the fixture; its range and its hysteresis."""
    area = inputs.bench.pad.overlap_length * inputs.conditions.width
    pressure = values["pressure"] * ndtr(-LIGHT) / ndtr(-LIGHT / np.asarray(values["range_ratio"]))
    return sockets.with_(
        adhesion_force=sockets.adhesion_force + pressure * area,
        fixture_adhesion_force=sockets.fixture_adhesion_force + values["fixture_share"] * pressure * area,
        adhesion_range=values["range_ratio"],
        adhesion_separating=values["separation_ratio"],
    )


EFFECT = Effect(
    name="surface_adhesion",
    role="candidate",
    stage="contact",
    action="adds",
    summary="attraction without voltage on the part of the overlap that touches",
    parameters=(
        Parameter(
            "pressure",
            "Pa",
            (0.0, 2e6),
            0.0,
            Prior("halfnormal", 6e4),
            neutral=0.0,
            description="attraction per contacting area, or what pulls as hard at two spreads of the gap",
        ),
        Parameter(
            "range_ratio",
            "1",
            (1.0, 10.0),
            1.5,
            Prior("lognormal", 1.5, 0.7),
            description="range of the attraction over the spread of gaps; 1: it ends with the contact",
        ),
        fixture_share("attraction"),
        Parameter(
            "separation_ratio",
            "1",
            (1.0, 10.0),
            1.0,
            Prior("lognormal", 1.0, 0.5),
            description="attraction from switch-off on over that before; 1: faces part as they met",
        ),
    ),
    reference=(
        "Derjaguin, Muller & Toporov, J. Colloid Interface Sci. 53 (1975) 314, doi:10.1016/0021-9797(75)90018-1; "
        "Israelachvili, Intermolecular and Surface Forces, 3rd ed. (2011), doi:10.1016/C2009-0-21560-1 (that surface "
        "forces fall with distance, and that faces part with a stronger pull); shape beyond contact chosen here"
    ),
    validity="stiff contacts (DMT, not JKR): no pull-off instability of single spots; one range, no force's own decay",
    apply=apply,
    draw=lambda rng: {
        "pressure": float(np.exp(rng.uniform(np.log(2e4), np.log(2e5)))),
        "range_ratio": 1.5,  # not drawn, nor the share: what recipes draw after this effect stays as it was
        "fixture_share": 1.0,
        "separation_ratio": 1.0,
    },
)
