"""Session drift: mounting, humidity and wear make a session differ from the next.

Each session s has an offset d_s from what the bench is otherwise. It multiplies the electroadhesive force by
exp((1 - c) d_s) and the friction coefficients by exp(c d_s), c the share that friction takes, the static ones by
exp(g c d_s) more: a junction that rests feels the humidity and the wear of its surfaces otherwise than one that slides.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import SESSIONS, Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """force_factor, friction_factor and the static factors of each run's session."""
    offset = inputs.of_session([values[f"offset_{number + 1}"] for number in range(SESSIONS)])
    share = np.asarray(values["friction_share"])
    static = np.exp(np.asarray(values["static_excess"]) * share * offset)
    return sockets.with_(
        force_factor=sockets.force_factor * np.exp((1.0 - share) * offset),
        friction_factor=sockets.friction_factor * np.exp(share * offset),
        static_factor_release=sockets.static_factor_release * static,
        static_factor_ramp=sockets.static_factor_ramp * static,
    )


def _draw(rng: np.random.Generator) -> dict[str, float]:
    sd = rng.uniform(0.1, 0.35)
    offsets = np.clip(rng.normal(0.0, sd, SESSIONS), -0.99, 0.99)
    drawn = {f"offset_{number + 1}": float(offsets[number]) for number in range(SESSIONS)}
    return drawn | {
        "friction_share": float(rng.uniform(0.0, 1.0)),
        "static_excess": float(np.clip(rng.normal(0.0, 0.5), -1.99, 3.99)),
    }


EFFECT = Effect(
    name="session_drift",
    role="candidate",
    stage="session",
    action="multiplies",
    summary="mounting, humidity, wear: a session differs from the next",
    parameters=(
        *(
            Parameter(
                f"offset_{number + 1}", "1", (-1.0, 1.0), 0.0, Prior("normal", 0.0, 0.2), neutral=0.0,
                description=f"log offset of session {number + 1} in order of time",
            )
            for number in range(SESSIONS)
        ),
        Parameter(
            "friction_share", "1", (0.0, 1.0), 0.3, Prior("uniform", 0.0, 1.0),
            description="share of the offset that changes friction, the rest changes the force",
        ),
        Parameter(
            "static_excess", "1", (-2.0, 4.0), 0.0, Prior("normal", 0.0, 1.0),
            description="by how much more static friction changes, a share of what all friction does",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (four "
        "sessions of its bench); log-normal session factors derived here"
    ),
    validity="offsets of a session are constant within it; up to eight sessions told apart",
    apply=apply,
    draw=_draw,
)  # fmt: skip
