"""Lost area: beyond some width a share of the pad holds nothing, because its outer fingers are burnt off or lie bare.
The force per width falls with wider strips, at every voltage alike."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """force_factor (1 - share (1 - w_sound / w)) where w > w_sound."""
    beyond = np.maximum(1.0 - values["sound_width"] / inputs.conditions.width, 0.0)
    return sockets.with_(force_factor=sockets.force_factor * (1.0 - values["share"] * beyond))


EFFECT = Effect(
    name="lost_area",
    role="lookalike",
    stage="electrostatics",
    action="multiplies",
    summary="outer electrodes that do not pull: wide strips hold less than their width says",
    parameters=(
        Parameter(
            "share",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("halfnormal", 0.3),
            neutral=0.0,
            description="of the width beyond the sound one that does not pull",
        ),
        Parameter(
            "sound_width",
            "m",
            (5e-4, 5e-3),
            2e-3,
            Prior("lognormal", 2e-3, 0.4),
            description="width up to which the pad is whole",
        ),
    ),
    reference=(
        "Hinchet & Shea, Adv. Mater. Technol. 5 (2020) 1900895, doi:10.1002/admt.201900895 (force of a clutch over its "
        "area); loss with width derived here"
    ),
    validity="electrodes that are dead for good; the film touches there all the same",
    apply=apply,
    draw=lambda rng: {
        "share": float(rng.uniform(0.1, 0.7)),
        "sound_width": float(rng.uniform(1.5e-3, 3e-3)),
    },
)
