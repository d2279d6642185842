"""Film weight: m_d g in the film's balance and in the normal forces."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import STRENGTH, Effect, Inputs
from eaclutch.physics.laws import GRAVITY
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """F_N gains m_d g times ``strength``."""
    return sockets.with_(film_weight=values["strength"] * inputs.film_mass * GRAVITY)


EFFECT = Effect(
    name="film_weight",
    role="base",
    stage="film",
    action="adds",
    summary="the film's own weight loads the contact",
    parameters=(STRENGTH,),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382; "
        "eq. of motion of the film"
    ),
    validity="film horizontal",
    apply=apply,
    draw=lambda rng: {"strength": 1.0},
)
