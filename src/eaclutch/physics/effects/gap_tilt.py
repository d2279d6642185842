"""Gap tilt: over a tilted overlap the mean gap varies linearly, which spreads the gaps by a uniform distribution
of sd angle w_s / sqrt(12) for a tilt across the width and lift / sqrt(12) for one end lifted along the strip; both
together are taken as one uniform spread of their joint sd. Contact, attraction and force are averaged over it. A strip
that is free to turn levels under its preload P: the tilt is 1 / (1 + l P) of what it is without. The capacitance
fixture, where the strip is pressed on the film by itself, has an unknown share of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior, fixture_share
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """gap_spread_sd = sqrt((angle w_s)^2 + lift^2) / sqrt(12) / (1 + l P), in quadrature with what is there."""
    across = values["angle"] * inputs.conditions.width
    spread = np.sqrt((across**2 + np.asarray(values["lift"]) ** 2) / 12.0)
    level = 1.0 + np.asarray(values["levelling"]) * np.maximum(inputs.preload, 0.0)
    return sockets.with_(
        gap_spread_sd=np.hypot(sockets.gap_spread_sd, spread / level),
        fixture_gap_spread_sd=np.hypot(sockets.fixture_gap_spread_sd, values["fixture_share"] * spread),
    )


EFFECT = Effect(
    name="gap_tilt",
    role="candidate",
    stage="contact",
    action="adds",
    summary="film and substrate are not parallel: the gaps spread over the overlap",
    parameters=(
        Parameter(
            "angle",
            "rad",
            (0.0, 0.02),
            0.0,
            Prior("halfnormal", 8e-4),
            neutral=0.0,
            description="tilt across the strip's width",
        ),
        Parameter(
            "lift",
            "m",
            (0.0, 5e-5),
            0.0,
            Prior("halfnormal", 3e-6),
            neutral=0.0,
            description="gap at one end of the strip against the other",
        ),
        Parameter(
            "levelling",
            "1/N",
            (0.0, 20.0),
            0.0,
            Prior("halfnormal", 0.5),
            description="by how much a newton of preload turns the strip level",
        ),
        fixture_share("spread"),
    ),
    reference=(
        "Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300, doi:10.1098/rspa.1966.0242 (distribution of "
        "heights); average over a uniform spread derived here"
    ),
    validity="half spread up to about two roughness sds; the squeezed air is that of a parallel gap",
    apply=apply,
    draw=lambda rng: {
        "angle": rng.uniform(2e-4, 2e-3),
        "lift": rng.uniform(0.0, 8e-6),
        "levelling": rng.uniform(0.0, 1.0),
        "fixture_share": rng.uniform(0.0, 1.0),
    },
)
