"""Trigger latency: the film's voltage follows the logged edge after a fixed delay (both edges): engagement and
every release quantile shift by the same amount, whatever the condition."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """drive_delay grows by the parameter."""
    return sockets.with_(drive_delay=sockets.drive_delay + values["delay"])


EFFECT = Effect(
    name="trigger_latency",
    role="candidate",
    stage="drive",
    action="adds",
    summary="a fixed delay between the logged voltage edge and the film's",
    parameters=(
        Parameter(
            "delay",
            "s",
            (0.0, 5e-3),
            0.0,
            Prior("halfnormal", 2e-4),
            neutral=0.0,
            description="delay of the film's voltage against the logged edge",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (its drive "
        "and data acquisition); pure delay"
    ),
    validity="the same delay at both edges and in all runs",
    apply=apply,
    draw=lambda rng: {
        "delay": rng.uniform(4e-5, 3e-4),
    },
)
