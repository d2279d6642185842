"""Electrostriction: thickness strain S = -M E^2 (material strain and Maxwell stress together), so that the film
is T_d (1 - M E^2) while driven; E is the nominal field in the film where the gap is closed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

LARGEST_STRAIN = 0.5


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """thinning_ratio = M E^2 at the drive amplitude, at most LARGEST_STRAIN."""
    return sockets.with_(
        thinning_ratio=np.minimum(values["coefficient"] * inputs.film_field**2, LARGEST_STRAIN)
    )


EFFECT = Effect(
    name="electrostriction",
    role="candidate",
    stage="dielectric",
    action="multiplies",
    summary="the film thins with the square of the field",
    parameters=(
        Parameter(
            "coefficient",
            "m2/V2",
            (0.0, 1.2e-14),
            0.0,
            Prior("halfnormal", 1.5e-15),
            neutral=0.0,
            description="M: thickness strain over field squared",
        ),
    ),
    reference=("Zhang, Bharti & Zhao, Science 280 (1998) 2101, doi:10.1126/science.280.5372.2101"),
    validity="strain up to a half (held there); real relaxor films reach about 4 % at 150 MV/m",
    apply=apply,
    draw=lambda rng: {
        "coefficient": rng.uniform(6e-16, 4e-15),
    },
)
