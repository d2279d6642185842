"""Squeeze film: F_b = -96 mu_air min(L_s, w_s)^3 max(L_s, w_s) / (pi^4 h^3) dh/dt."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import STRENGTH, Effect, Inputs
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """The squeeze-film coefficient counts with weight ``strength`` (0: the gap follows its equilibrium)."""
    return sockets.with_(damping_factor=sockets.damping_factor + values["strength"])


EFFECT = Effect(
    name="squeeze_film",
    role="base",
    stage="film",
    action="adds",
    summary="air squeezed out of the gap damps the film",
    parameters=(STRENGTH,),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382; "
        "Bao & Yang, Sens. Actuators A 136 (2007) 3, doi:10.1016/j.sna.2007.01.008"
    ),
    validity="isothermal, incompressible (low squeeze number), gap well above the mean free path of 68 nm",
    apply=apply,
    draw=lambda rng: {"strength": 1.0},
)
