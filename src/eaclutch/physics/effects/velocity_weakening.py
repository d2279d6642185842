"""Velocity weakening (Stribeck-type): mu_k(v) = mu_k (1 - d (1 - exp(-|v| / v_s))). Slips go deeper and release
is faster, the more so the higher the load that is let go; slow sliding before the voltage keeps mu_k."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """weakening_depth = d, weakening_speed = v_s."""
    return sockets.with_(weakening_depth=values["depth"], weakening_speed=values["speed"])


EFFECT = Effect(
    name="velocity_weakening",
    role="candidate",
    stage="friction",
    action="multiplies",
    summary="kinetic friction falls with sliding speed",
    parameters=(
        Parameter(
            "depth",
            "1",
            (0.0, 0.95),
            0.0,
            Prior("halfnormal", 0.3),
            neutral=0.0,
            description="share of kinetic friction lost at high speed",
        ),
        Parameter(
            "speed",
            "m/s",
            (1e-3, 2.0),
            0.03,
            Prior("lognormal", 0.03, 1.2),
            description="sliding speed at which 63 % of it is lost",
        ),
    ),
    reference=(
        "Armstrong-Helouvry, Dupont & Canudas de Wit, Automatica 30 (1994) 1083, "
        "doi:10.1016/0005-1098(94)90209-7"
    ),
    validity="speeds above the stage speed: friction there is the slow limit",
    apply=apply,
    draw=lambda rng: {
        "depth": rng.uniform(0.15, 0.8),
        "speed": float(np.exp(rng.uniform(np.log(5e-3), np.log(0.2)))),
    },
)
