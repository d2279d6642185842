"""Film tension: the film is clamped beside the strip; pulled towards it by h_before - h it answers with a spring
force s (h_before - h), s proportional to the overlap length. What part of the preload it carries from the start
cannot be seen: the preload is known from the friction before, which only feels what reaches the strip."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """film_spring = s' L_s."""
    return sockets.with_(
        film_spring=sockets.film_spring + values["stiffness"] * inputs.bench.pad.overlap_length
    )


EFFECT = Effect(
    name="film_tension",
    role="candidate",
    stage="film",
    action="adds",
    summary="the stretched, bent film carries part of the load",
    parameters=(
        Parameter(
            "stiffness",
            "N/m2",
            (0.0, 5e6),
            0.0,
            Prior("halfnormal", 4e5),
            neutral=0.0,
            description="restoring force per gap closed and overlap length",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (clamped "
        "film of its bench); linear membrane spring derived here"
    ),
    validity="gap changes small against the span of the film",
    apply=apply,
    draw=lambda rng: {
        "stiffness": float(np.exp(rng.uniform(np.log(1e5), np.log(1.5e6)))),
    },
)
