"""Leaky film: while one polarity lasts, charge that creeps through the film changes the field between film and strip.
It drains it (onto the strip, through the contacts) or adds to it (up to the film's surface, Johnsen-Rahbek), and goes
with the voltage: unlike trapped charge it leaves nothing behind after switch-off."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """force_factor (1 - drained (1 - exp(-t_h / leak_time)))^2, t_h the time that one polarity lasts."""
    leaked = -np.expm1(-inputs.polarity_time / np.asarray(values["leak_time"]))
    return sockets.with_(
        force_factor=sockets.force_factor * (1.0 - np.asarray(values["drained"]) * leaked) ** 2
    )


EFFECT = Effect(
    name="leaky_film",
    role="lookalike",
    stage="electrostatics",
    action="multiplies",
    summary="a film that leaks: the force changes with the time that one polarity lasts",
    parameters=(
        Parameter(
            "drained",
            "1",
            (-2.0, 0.95),
            0.0,
            Prior("normal", 0.0, 0.15),
            neutral=0.0,
            description="share of the field that a long polarity loses (below 0: gains)",
        ),
        Parameter(
            "leak_time",
            "s",
            (1e-4, 10.0),
            0.03,
            Prior("lognormal", 0.03, 1.5),
            description="permittivity over conductivity of what leaks",
        ),
    ),
    reference=(
        "Qin & McTeer, J. Appl. Phys. 102 (2007) 064901, doi:10.1063/1.2778633 (Johnsen-Rahbek chucks); Maxwell-Wagner "
        "relaxation of one time derived here"
    ),
    validity="a leak at the same rate at every voltage, and gone with it",
    apply=apply,
    draw=lambda rng: {
        "drained": float(rng.choice([-1.0, 1.0]) * rng.uniform(0.1, 0.4)),
        "leak_time": float(np.exp(rng.uniform(np.log(3e-3), np.log(0.3)))),
    },
)
