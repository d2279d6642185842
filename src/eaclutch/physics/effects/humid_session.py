"""Humid session: on one day more is adsorbed between film and strip than on another, and resists their parting. Each
session has a damping of its own beside that of the air; friction and force stay."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import SESSIONS, Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """damping_factor + gain of each run's session."""
    more = inputs.of_session([values[f"gain_{number + 1}"] for number in range(SESSIONS)])
    return sockets.with_(damping_factor=sockets.damping_factor + more)


EFFECT = Effect(
    name="humid_session",
    role="lookalike",
    stage="film",
    action="adds",
    summary="a humid day: the release slows in some sessions, friction and force stay",
    parameters=tuple(
        Parameter(
            f"gain_{number + 1}",
            "1",
            (0.0, 200.0),
            0.0,
            Prior("halfnormal", 6.0),
            neutral=0.0,
            description=f"further damping over that of the air in session {number + 1} in order of time",
        )
        for number in range(SESSIONS)
    ),
    reference=(
        "Persson, J. Phys.: Condens. Matter 20 (2008) 315007, doi:10.1088/0953-8984/20/31/315007 (liquid between rough "
        "solids); a damping for each session derived here"
    ),
    validity="a viscous resistance to parting alone, constant within a session; up to eight sessions told apart",
    apply=apply,
    draw=lambda rng: {
        f"gain_{number + 1}": float(np.exp(rng.uniform(np.log(0.5), np.log(20.0))))
        for number in range(SESSIONS)
    },
)
