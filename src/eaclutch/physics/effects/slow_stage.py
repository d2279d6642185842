"""Slow stage: steps that a stepper loses, or a lead that is not the screw's, let the stage move slower than it is told.
The force climbs more slowly, as with a film that gives in shear; nothing else changes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """stage_speed_factor 1 - lost."""
    return sockets.with_(stage_speed_factor=sockets.stage_speed_factor * (1.0 - np.asarray(values["lost"])))


EFFECT = Effect(
    name="slow_stage",
    role="lookalike",
    stage="load_train",
    action="multiplies",
    summary="a stage that loses steps: slower than it is told, so the force climbs more slowly",
    parameters=(
        Parameter(
            "lost",
            "1",
            (0.0, 0.95),
            0.0,
            Prior("halfnormal", 0.3),
            neutral=0.0,
            description="share of the stage's speed",
        ),
    ),
    reference=(
        "Acarnley, Stepping Motors, 4th ed., IET 2002, doi:10.1049/PBCE063E (lost steps); the climb's rate derived "
        "here"
    ),
    validity="steps lost evenly, at every force alike",
    apply=apply,
    draw=lambda rng: {"lost": float(rng.uniform(0.1, 0.6))},
)
