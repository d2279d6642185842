"""Sluggish contact: asperities of a polymer recover from their load in a time of their own, so that part of the film's
friction outlives the pull that has gone. That part follows L' = (F_k - L) / t after switch-off, t = lag (F_k0 / 1 N)^p
with the contact force F_k0 that is released. While driven, contact and load have long come to terms. Unlike a slow
drive it knows no capacitance, costs nothing at reversals of polarity, and lets the film part at once."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """contact_lag, contact_lag_share and contact_lag_power; no lag, no share."""
    lag = values["lag"]
    return sockets.with_(
        contact_lag=lag,
        contact_lag_share=np.where(lag > 0.0, values["share"], 0.0),
        contact_lag_power=np.where(lag > 0.0, values["load_exponent"], 0.0),
    )


EFFECT = Effect(
    name="sluggish_contact",
    role="lookalike",
    stage="friction",
    action="adds",
    summary="contacts that recover from their load in their own time: friction outlives the pull",
    parameters=(
        Parameter(
            "lag",
            "s",
            (0.0, 0.02),
            0.0,
            Prior("halfnormal", 3e-4),
            neutral=0.0,
            description="time in which the film's friction follows a contact force of 1 N",
        ),
        Parameter(
            "share",
            "1",
            (0.0, 1.0),
            0.5,
            Prior("uniform", 0.0, 1.0),
            description="of the film's friction that lags; the rest follows at once",
        ),
        Parameter(
            "load_exponent",
            "1",
            (-1.0, 1.0),
            0.0,
            Prior("normal", 0.0, 0.4),
            description="power of the released contact force in that time",
        ),
    ),
    reference=(
        "Lee & Radok, J. Appl. Mech. 27 (1960) 438, doi:10.1115/1.3644020 (contact of viscoelastic bodies); one "
        "relaxation time, assumed here"
    ),
    validity="release; a ramp lasts much longer than the lag; the film's friction, not the base's",
    apply=apply,
    draw=lambda rng: {
        "lag": float(np.exp(rng.uniform(np.log(1e-4), np.log(1e-3)))),
        "share": float(rng.uniform(0.3, 1.0)),
        "load_exponent": float(rng.uniform(-0.5, 0.5)),
    },
)
