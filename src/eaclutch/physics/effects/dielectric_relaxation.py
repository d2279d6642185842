"""Polarisation: kappa(w) = kappa_inf + (kappa_s - kappa_inf) / (1 + (j w tau)^alpha); after a change of the
field kappa relaxes as a Mittag-Leffler function of time, continuous at the edges."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import STRENGTH, Effect, Inputs
from eaclutch.physics.laws import permittivity
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """kappa while driven is Re kappa(f), then Mittag-Leffler; ``strength`` scales both (0: kappa_s)."""
    p = inputs.parameters
    kappa = permittivity(
        inputs.conditions.frequency,
        p["kappa_static"],
        p["kappa_infinity"],
        p["relaxation_time"],
        p["cole_cole_exponent"],
    )
    strength = values["strength"]
    # dipoles keep up with a field that changes more slowly than they do, and do not relax as after a step
    follows = 1.0 / (1.0 + np.asarray(sockets.field_lag) / p["relaxation_time"])
    return sockets.with_(
        kappa_driven=p["kappa_static"] + strength * (kappa - p["kappa_static"]), relaxing=strength * follows
    )


EFFECT = Effect(
    name="dielectric_relaxation",
    role="base",
    stage="dielectric",
    action="replaces",
    summary="the film's permittivity disperses and relaxes by the Cole-Cole law",
    parameters=(STRENGTH,),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382; "
        "Cole & Cole, J. Chem. Phys. 9 (1941) 341, doi:10.1063/1.1750906"
    ),
    validity="linear dielectric, one relaxation, 0 < alpha <= 1",
    apply=apply,
    draw=lambda rng: {"strength": 1.0},
)
