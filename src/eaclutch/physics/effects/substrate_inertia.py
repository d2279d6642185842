"""Substrate inertia: while the tip pushes, a share of the substrate's mass (strip and what it carries) moves
with it: m = m_lc + participation m_s. The swing is slower and the release takes longer with wider strips."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """added_mass = participation m_s."""
    return sockets.with_(added_mass=sockets.added_mass + values["participation"] * inputs.substrate_mass)


EFFECT = Effect(
    name="substrate_inertia",
    role="candidate",
    stage="load_train",
    action="adds",
    summary="the substrate's mass moves with the load cell",
    parameters=(
        Parameter(
            "participation",
            "1",
            (0.0, 2.0),
            0.0,
            Prior("halfnormal", 0.6),
            neutral=0.0,
            description="share of the substrate's mass that moves with the tip",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (masses of "
        "its bench); lumped mass derived here"
    ),
    validity="rigid substrate; 1 is the whole strip, above 1 what else is carried along",
    apply=apply,
    draw=lambda rng: {
        "participation": rng.uniform(0.15, 1.0),
    },
)
