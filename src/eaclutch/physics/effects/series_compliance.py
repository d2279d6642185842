"""Series compliance: film in shear, glue and mount give way under the shear force, so that the tip sees
1 / k = 1 / k_lc + c: the ramp is slower and a stuck clutch stores more energy. What gives in the load train swings with
the tip, which is slower for it; what gives behind the sliding face (the film, its glue) is bent by the friction as long
as the strip slides, and takes no part in a swing. The mount gives alike under all strips, a film in shear the less the
wider the strip that shears it: c = c_0 (w_0 / w_s)^p."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """c_0 (w_0 / w_s)^p: the share of the film, and the rest, which is the load train's."""
    give = values["compliance"] * inputs.relative_width ** -np.asarray(values["width_exponent"])
    share = np.asarray(values["film_share"])
    return sockets.with_(
        series_compliance=sockets.series_compliance + (1.0 - share) * give,
        film_compliance=sockets.film_compliance + share * give,
    )


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
            Prior("halfnormal", 3e-5),
            neutral=0.0,
            description="elastic give in series with the load cell (whose own is 5.5e-5), with a strip 2 mm wide",
        ),
        Parameter(
            "width_exponent",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("uniform", 0.0, 1.0),
            description="0: the mount gives, 1: the film does, in shear under the strip",
        ),
        Parameter(
            "film_share",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("uniform", 0.0, 1.0),
            description="of what gives behind the sliding face and takes no part in a swing",
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
        "width_exponent": float(rng.uniform(0.0, 1.0)),
        "film_share": float(rng.uniform(0.0, 1.0)),
    },
)
