"""Surface adhesion (DMT): outside forces act like an added load on the contacting spots. The share of a Gaussian
surface at or below zero gap is Phi(-h / sigma), so the load is p_a L_s w_s Phi(-h / sigma), voltage or not."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """adhesion_force = p_a L_s w_s at full contact."""
    area = inputs.bench.pad.overlap_length * inputs.conditions.width
    return sockets.with_(adhesion_force=sockets.adhesion_force + values["pressure"] * area)


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
            description="attraction per contacting area",
        ),
    ),
    reference=(
        "Derjaguin, Muller & Toporov, J. Colloid Interface Sci. 53 (1975) 314, doi:10.1016/0021-9797(75)90018-1"
    ),
    validity="stiff contacts (DMT, not JKR): no pull-off instability of single spots",
    apply=apply,
    draw=lambda rng: {
        "pressure": float(np.exp(rng.uniform(np.log(2e4), np.log(2e5)))),
    },
)
