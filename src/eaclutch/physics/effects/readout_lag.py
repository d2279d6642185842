"""Readout lag: a low pass in the amplifier behind the load cell. The logged force follows the true one with a time
constant: a release is logged late, by little where it begins and by the whole time constant once it is under way."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """readout_time = time_constant."""
    return sockets.with_(readout_time=sockets.readout_time + values["time_constant"])


EFFECT = Effect(
    name="readout_lag",
    role="lookalike",
    stage="readout",
    action="adds",
    summary="a low pass behind the load cell: the logged force lags",
    parameters=(
        Parameter(
            "time_constant",
            "s",
            (0.0, 3e-3),
            0.0,
            Prior("halfnormal", 3e-4),
            neutral=0.0,
            description="of a first-order low pass between the force and its log",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (their readout); "
        "low pass derived here"
    ),
    validity="the release and a run's history; slips, which take milliseconds too, stay as they are",
    apply=apply,
    draw=lambda rng: {"time_constant": float(np.exp(rng.uniform(np.log(8e-5), np.log(6e-4))))},
)
