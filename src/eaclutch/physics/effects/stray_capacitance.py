"""Stray capacitance: leads and fixture add a constant capacitance to every reading of the capacitance bench, so
that gaps read off it are too small and the contact law too stiff at light loads. The clutch itself is as before."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """stray_capacitance of the fixture grows by the parameter."""
    return sockets.with_(stray_capacitance=sockets.stray_capacitance + values["capacitance"])


EFFECT = Effect(
    name="stray_capacitance",
    role="candidate",
    stage="capacitance_bench",
    action="adds",
    summary="a parallel capacitance left in the capacitance readings biases the gaps",
    parameters=(
        Parameter(
            "capacitance",
            "F",
            (0.0, 1e-10),
            0.0,
            Prior("halfnormal", 8e-12),
            neutral=0.0,
            description="parallel capacitance left in the readings, beyond what campaign.yaml declares",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (its "
        "capacitance bench); parallel capacitors"
    ),
    validity="the same for all readings of the bench",
    apply=apply,
    draw=lambda rng: {
        "capacitance": rng.uniform(2e-12, 2e-11),
    },
    exact=True,  # capacitances in parallel add
)
