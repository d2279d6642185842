"""Wet film: what is adsorbed between film and strip resists their parting, the more the harder they were pressed. A
damping that grows with a power of the preload acts beside that of the air; friction and force stay."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

REFERENCE_PRELOAD = 0.5  # N


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """damping_factor + gain (P / 0.5 N)^n."""
    pressed = np.maximum(inputs.preload, 0.0) / REFERENCE_PRELOAD
    more = values["gain"] * pressed ** np.asarray(values["preload_exponent"])
    return sockets.with_(damping_factor=sockets.damping_factor + more)


EFFECT = Effect(
    name="wet_film",
    role="lookalike",
    stage="film",
    action="adds",
    summary="an adsorbed film that resists parting: the release slows with preload, friction stays",
    parameters=(
        Parameter(
            "gain",
            "1",
            (0.0, 200.0),
            0.0,
            Prior("halfnormal", 6.0),
            neutral=0.0,
            description="further damping over that of the air at 0.5 N of preload",
        ),
        Parameter(
            "preload_exponent",
            "1",
            (0.0, 2.0),
            0.5,
            Prior("normal", 0.5, 0.4),
            description="the further damping grows as the preload to this power",
        ),
    ),
    reference=(
        "Persson, J. Phys.: Condens. Matter 20 (2008) 315007, doi:10.1088/0953-8984/20/31/315007 (liquid between rough "
        "solids); law derived here"
    ),
    validity="a viscous resistance to parting alone",
    apply=apply,
    draw=lambda rng: {
        "gain": float(np.exp(rng.uniform(np.log(2.0), np.log(20.0)))),
        "preload_exponent": float(rng.uniform(0.2, 1.0)),
    },
)
