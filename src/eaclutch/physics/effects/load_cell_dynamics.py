"""Load cell: m_lc x'' = -k_lc x - b_lc x' - F_shear sign(x'), stuck or sliding."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import STRENGTH, Effect, Inputs
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Dynamic from ``strength`` 0.5 on; below, the reading follows the friction (x = F_shear / k_lc)."""
    return sockets.with_(load_cell_dynamic=np.where(np.asarray(values["strength"]) >= 0.5, 1.0, 0.0))


EFFECT = Effect(
    name="load_cell_dynamics",
    role="base",
    stage="load_train",
    action="replaces",
    summary="the load cell is a mass on a damped spring with stick-slip friction",
    parameters=(STRENGTH,),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382; "
        "load-cell model of the release"
    ),
    validity="a switch: there is nothing between a dynamic and a massless load cell",
    apply=apply,
    draw=lambda rng: {"strength": 1.0},
    exact=True,  # on or off
)
