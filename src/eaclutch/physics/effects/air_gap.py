"""Air gap: F_ea = kappa^2 eps0 N A (V/2)^2 / (2 (T_d + kappa h)^2) instead of the bare film's
kappa eps0 N A (V/2)^2 / (2 T_d^2). The kernel weighs the two by ``gap_in_force``."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import STRENGTH, Effect, Inputs
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """The force with the gap has weight ``strength`` against the bare film's."""
    return sockets.with_(gap_in_force=values["strength"])


EFFECT = Effect(
    name="air_gap",
    role="base",
    stage="electrostatics",
    action="replaces",
    summary="the force sees film and air gap in series",
    parameters=(STRENGTH,),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382; "
        "Persson, J. Chem. Phys. 148 (2018) 144701, doi:10.1063/1.5024038"
    ),
    validity="gap above -c T_d / kappa (the cut of the roughness average); fringe fields left out",
    apply=apply,
    draw=lambda rng: {"strength": 1.0},
)
