"""Drive: V(t) = V0 (1 - exp(-t / tau_rise)) and V0 exp(-t / tau_fall), tau = t_10-90 / ln 9.

A drive that turns its polarity with the same edges passes through zero at each turn, and a film too slow to follow
feels the mean square that is left of a square wave (15 % of the pull is lost at 10 kHz with the published rise).
The base model's statement holds the voltage between on and off, and a bench may do either: how much of that loss there
is, the diagnosis calibrates; everything else leaves it out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics import laws
from eaclutch.physics.effect import STRENGTH, Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Time constants t_10-90 / ln 9 of the bench's drive, times ``strength`` (0: a step); what reversals cost scales
    the force."""
    drive = inputs.bench.drive
    rise = values["strength"] * drive.rise_10_90 / np.log(9.0)
    lost = 1.0 - laws.kept_mean_square(rise, 0.5 / inputs.conditions.frequency)
    return sockets.with_(
        force_factor=sockets.force_factor * (1.0 - values["reversal_share"] * lost),
        rise_time_constant=rise,
        fall_time_constant=values["strength"] * drive.fall_90_10 / np.log(9.0),
    )


EFFECT = Effect(
    name="drive_rise_fall",
    role="base",
    stage="drive",
    action="replaces",
    summary="the voltage rises and falls exponentially",
    parameters=(
        STRENGTH,
        Parameter(
            "reversal_share",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("uniform", 0.0, 1.0),
            description="of what edges at reversals of polarity would cost; 0: polarity turns without a loss",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382; "
        "measured rise and fall of its drive circuit; mean square of a square wave derived here"
    ),
    validity="single-pole edges; reversals that the film is too slow to follow",
    apply=apply,
    draw=lambda rng: {"strength": 1.0, "reversal_share": 0.0},
)
