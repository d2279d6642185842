"""Drive: V(t) = V0 (1 - exp(-t / tau_rise)) and V0 exp(-t / tau_fall), tau = t_10-90 / ln 9."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import STRENGTH, Effect, Inputs
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Time constants t_10-90 / ln 9 of the bench's drive, times ``strength`` (0: a step)."""
    drive = inputs.bench.drive
    return sockets.with_(
        rise_time_constant=values["strength"] * drive.rise_10_90 / np.log(9.0),
        fall_time_constant=values["strength"] * drive.fall_90_10 / np.log(9.0),
    )


EFFECT = Effect(
    name="drive_rise_fall",
    role="base",
    stage="drive",
    action="replaces",
    summary="the voltage rises and falls exponentially",
    parameters=(STRENGTH,),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382; "
        "measured rise and fall of its drive circuit"
    ),
    validity="single-pole edges",
    apply=apply,
    draw=lambda rng: {"strength": 1.0},
)
