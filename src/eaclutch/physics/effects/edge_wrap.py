"""Edge wrap: the preload bends the compliant film round the substrate's edges, so that it rubs on the side
walls too. The normal force on the side walls is taken proportional to the preload, and so are the friction it
adds beside base and film (static and kinetic, in the film's ratio) and a viscous damping of the sliding. Side
friction is part of the friction before the voltage, from which the preload is known: F_before = (mu + c_f) F_pre
+ weights, with mu = mu_b + mu_d, so the preload is mu / (mu + c_f) of what the base model makes of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Side friction c_f F_pre (kinetic; static in the film's ratio) and side damping c_d F_pre."""
    p = inputs.parameters
    coefficient = np.asarray(values["friction_per_preload"])
    sliding = p["base_kinetic"] + p["film_kinetic"]
    preload = np.maximum(inputs.preload, 0.0) * sliding / (sliding + coefficient)
    kinetic = coefficient * preload
    return sockets.with_(
        side_friction=sockets.side_friction + kinetic,
        side_friction_static=sockets.side_friction_static + kinetic * p["film_static"] / p["film_kinetic"],
        side_damping=sockets.side_damping + values["damping_per_preload"] * preload,
    )


EFFECT = Effect(
    name="edge_wrap",
    role="candidate",
    stage="friction",
    action="adds",
    summary="preload bends the film round the edges: side friction and damping that grow with preload",
    parameters=(
        Parameter(
            "friction_per_preload",
            "1",
            (0.0, 3.0),
            0.0,
            Prior("halfnormal", 0.2),
            neutral=0.0,
            description="kinetic side-wall friction over preload",
        ),
        Parameter(
            "damping_per_preload",
            "kg/s/N",
            (0.0, 50.0),
            0.0,
            Prior("halfnormal", 2.0),
            neutral=0.0,
            description="viscous side-wall damping over preload",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (their "
        "conjecture for release slowing with preload); linear law derived here"
    ),
    validity="the film stays elastic; side friction is proportional to preload, not to the drive",
    apply=apply,
    draw=lambda rng: {
        "friction_per_preload": rng.uniform(0.05, 0.5),
        "damping_per_preload": rng.uniform(0.5, 6.0),
    },
)
