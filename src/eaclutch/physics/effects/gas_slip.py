"""Gas slip (Burgdorfer, first order): the flow of a gap h grows by 1 + 6 l / h with l the mean free path, so the
squeeze-film damping falls: F_b = -c / (h^2 (h + 6 l)) dh/dt. For air at 1 bar l = 68 nm."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """slip_length = l."""
    return sockets.with_(slip_length=sockets.slip_length + values["mean_free_path"])


EFFECT = Effect(
    name="gas_slip",
    role="candidate",
    stage="film",
    action="multiplies",
    summary="rarefied gas in a micrometre gap damps less",
    parameters=(
        Parameter(
            "mean_free_path",
            "m",
            (0.0, 5e-5),
            0.0,
            Prior("halfnormal", 2e-6),
            neutral=0.0,
            description="effective slip length of the gas (68 nm for smooth walls at 1 bar)",
        ),
    ),
    reference=(
        "Burgdorfer, J. Basic Eng. 81 (1959) 94 (slip flow in gas bearings); "
        "Bao & Yang, Sens. Actuators A 136 (2007) 3, doi:10.1016/j.sna.2007.01.008 (squeeze films in rarefied gas)"
    ),
    validity="Knudsen number l / h below about 0.1 for the law itself; larger values stand for leaking, grooved walls",
    apply=apply,
    draw=lambda rng: {
        "mean_free_path": float(np.exp(rng.uniform(np.log(2e-7), np.log(1e-5)))),
    },
)
