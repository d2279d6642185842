"""Series compliance: film in shear, glue and mount give way under the shear force, so that the tip sees
1 / k = 1 / k_lc + c: the ramp is slower, a stuck clutch stores more energy, the loaded load train is softer."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """c adds to the load train's compliance."""
    return sockets.with_(series_compliance=sockets.series_compliance + values["compliance"])


EFFECT = Effect(
    name="series_compliance",
    role="candidate",
    stage="load_train",
    action="adds",
    summary="an elastic part in series with the load cell stores energy and slows the ramp",
    parameters=(
        Parameter(
            "compliance",
            "m/N",
            (0.0, 2e-4),
            0.0,
            Prior("halfnormal", 1.5e-5),
            neutral=0.0,
            description="elastic give in series with the load cell (whose own is 5.5e-5)",
        ),
    ),
    reference=(
        "Hinchet & Shea, Adv. Mater. Technol. 5 (2020) 1900895, doi:10.1002/admt.201900895 (film in shear); "
        "series springs derived here"
    ),
    validity="linear, massless part; small against the travel",
    apply=apply,
    draw=lambda rng: {
        "compliance": rng.uniform(4e-6, 4e-5),
    },
)
