"""Gap tilt: over a tilted overlap the mean gap varies linearly, which spreads the gaps by a uniform distribution
of sd angle w_s / sqrt(12) for a tilt across the width and lift / sqrt(12) for one end lifted along the strip; both
together are taken as one uniform spread of their joint sd. Contact, attraction and force are averaged over it.

A strip that is free to turn levels the closer preload and pull bring it to the film, and tilts again as the film lets
go: the tilt is 1 / (1 + l F) of what it is far away, F what parallel faces would carry at that gap. A tilted strip
carries more than that, and to take its own load would be a fixed point in every force. The squeezed air, whose damping
goes as 1 / h^3, sees a share of the spread: all of a lift along the strip, for it flows across, 0.3 of a tilt across,
where it flows out at the open side (Reynolds' equation to the second order), and less where the strip turns as the film
moves. So that share is free. The capacitance fixture, where the strip is pressed on the film by itself, has an unknown
share of the spread, the same at every load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior, fixture_share
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """gap_spread_sd = sqrt((angle w_s)^2 + lift^2) / sqrt(12), in quadrature with what is there."""
    across = values["angle"] * inputs.conditions.width
    spread = np.sqrt((across**2 + np.asarray(values["lift"]) ** 2) / 12.0)
    return sockets.with_(
        gap_spread_sd=np.hypot(sockets.gap_spread_sd, spread),
        gap_levelling=np.where(spread > 0.0, values["levelling"], sockets.gap_levelling),
        gap_in_air=np.where(spread > 0.0, values["air_share"], sockets.gap_in_air),
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
            Prior("halfnormal", 0.2),
            description="by how much it turns level for a newton that parallel faces would carry",
        ),
        Parameter(
            "air_share",
            "1",
            (0.0, 1.0),
            0.5,
            Prior("uniform", 0.0, 1.0),
            description="share of the spread that the squeezed air sees",
        ),
        fixture_share("spread"),
    ),
    reference=(
        "Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300, doi:10.1098/rspa.1966.0242 (distribution of "
        "heights); average over a uniform spread and the air's share derived here"
    ),
    validity="half spread up to about two roughness sds; the air's to the second order, without slip",
    apply=apply,
    draw=lambda rng: {
        "angle": rng.uniform(2e-4, 2e-3),
        "lift": rng.uniform(0.0, 8e-6),
        "levelling": rng.uniform(0.0, 0.5),
        "air_share": rng.uniform(0.0, 1.0),
        "fixture_share": rng.uniform(0.0, 1.0),
    },
)
