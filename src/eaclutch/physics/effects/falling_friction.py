"""Falling friction: under large loads the friction falls behind the normal force, because the contacts grow more slowly
than their load (polymers: as its power 2/3 to 0.9), because a clamp gives and the pad pitches, or because the load cell
reads them short. F becomes F / (1 + (F / F_c)^n)^(1 / n), with F_c as the width to a power between 0 (the whole
force counts) and 1 (the pressure does). The friction before the voltage is small, and stays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

REFERENCE_WIDTH = 2e-3  # m, the rig's most usual strip


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """softening s (w_ref / w)^q and its power n."""
    narrower = REFERENCE_WIDTH / inputs.conditions.width
    softening = values["softening"] * narrower ** np.asarray(values["width_exponent"])
    return sockets.with_(softening=softening, softening_power=np.where(softening > 0.0, values["power"], 1.0))


EFFECT = Effect(
    name="falling_friction",
    role="lookalike",
    stage="friction",
    action="multiplies",
    summary="friction that falls behind its load: strong strips hold less than their force says",
    parameters=(
        Parameter(
            "softening",
            "1/N",
            (0.0, 5.0),
            0.0,
            Prior("halfnormal", 0.15),
            neutral=0.0,
            description="over the driven friction at 2 mm: by what it falls short, to first order at a power of 1",
        ),
        Parameter(
            "power",
            "1",
            (0.5, 4.0),
            1.5,
            Prior("lognormal", 1.5, 0.4),
            description="1: gradually, 2: as a clamp that pitches, above: towards a limit",
        ),
        Parameter(
            "width_exponent",
            "1",
            (0.0, 1.0),
            0.3,
            Prior("uniform", 0.0, 1.0),
            description="0: the force counts, 1: the pressure",
        ),
    ),
    reference=(
        "Archard, Proc. R. Soc. A 243 (1957) 190, doi:10.1098/rspa.1957.0214 (elastic contacts: powers of the load "
        "from 2/3 to nearly 1); saturating form derived here"
    ),
    validity="the driven friction before its release; what is left of it afterwards is small",
    apply=apply,
    draw=lambda rng: {
        "softening": float(rng.uniform(0.1, 0.5)),
        "power": float(rng.uniform(1.0, 2.0)),
        "width_exponent": float(rng.uniform(0.0, 1.0)),
    },
)
