"""Roughness: F_ea averaged over gaps tau ~ Normal(h, sigma^2) above the cut (or at max(tau, 0), rule
``clamped``). Off, the force is that of the flat gap h while the contact law keeps its sigma."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import STRENGTH, Effect, Inputs
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """The averaged force has weight ``strength`` against the flat one; the rule (published or clamped) is the
    model's choice."""
    return sockets.with_(roughness_in_force=values["strength"])


EFFECT = Effect(
    name="surface_roughness",
    role="base",
    stage="electrostatics",
    action="replaces",
    summary="the force is averaged over a Gaussian spread of gaps",
    parameters=(STRENGTH,),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382; "
        "Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300, doi:10.1098/rspa.1966.0242"
    ),
    validity="sd below a few gaps; under the published rule two thirds of the force stem from gaps below zero",
    apply=apply,
    draw=lambda rng: {"strength": 1.0},
)
