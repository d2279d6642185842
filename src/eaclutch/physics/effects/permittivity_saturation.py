"""Permittivity saturation (Johnson's relation from the Landau expansion): kappa(E) = kappa / (1 + b E^2)^(1/3),
with E the nominal field in the film where the gap is closed; it follows the instantaneous voltage."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """saturation_ratio = b E^2 at the drive amplitude."""
    return sockets.with_(saturation_ratio=values["coefficient"] * inputs.film_field**2)


EFFECT = Effect(
    name="permittivity_saturation",
    role="candidate",
    stage="dielectric",
    action="multiplies",
    summary="the permittivity falls with the field in the film",
    parameters=(
        Parameter(
            "coefficient",
            "m2/V2",
            (0.0, 1e-12),
            0.0,
            Prior("halfnormal", 1.5e-14),
            neutral=0.0,
            description="b in kappa / (1 + b E^2)^(1/3)",
        ),
    ),
    reference=(
        "Ang & Yu, Phys. Rev. B 69 (2004) 174109, doi:10.1103/PhysRevB.69.174109 (Johnson's relation)"
    ),
    validity="one polarisation mechanism, no hysteresis; the field is that of closed spots, not of the mean gap",
    apply=apply,
    draw=lambda rng: {
        "coefficient": float(np.exp(rng.uniform(np.log(5e-15), np.log(6e-14)))),
    },
)
