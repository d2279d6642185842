"""Viscous drag: grease or moisture under the strip drags on it as it slides, in proportion to its speed. Unlike what
rubs at the walls it does not hold a strip that rests, knows no preload, and is not pulled by the voltage."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """side_damping + drag (w / w_0)^n."""
    wetted = inputs.relative_width ** np.asarray(values["width_exponent"])
    return sockets.with_(side_damping=sockets.side_damping + values["drag"] * wetted)


EFFECT = Effect(
    name="viscous_drag",
    role="lookalike",
    stage="friction",
    action="adds",
    summary="grease or moisture under the strip: a drag that grows with its speed, whatever the preload",
    parameters=(
        Parameter(
            "drag",
            "kg/s",
            (0.0, 50.0),
            0.0,
            Prior("halfnormal", 1.0),
            neutral=0.0,
            description="viscous damping of the sliding strip, 2 mm wide",
        ),
        Parameter(
            "width_exponent",
            "1",
            (0.0, 1.0),
            0.5,
            Prior("uniform", 0.0, 1.0),
            description="1: all of the strip's width is wet, 0: a spot of it",
        ),
    ),
    reference=(
        "Persson, J. Phys.: Condens. Matter 20 (2008) 315007, doi:10.1088/0953-8984/20/31/315007 (liquid between rough "
        "solids); drag of a thin layer derived here"
    ),
    validity="a layer that keeps its thickness; at stage speed its drag is too small to be seen in the friction",
    apply=apply,
    draw=lambda rng: {
        "drag": float(np.exp(rng.uniform(np.log(0.3), np.log(3.0)))),
        "width_exponent": float(rng.uniform(0.0, 1.0)),
    },
)
