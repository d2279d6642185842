"""Slow drive: the pad's voltage lags by R C (V / 300 V)^p with C the closed pad's capacitance, so by more the wider
the strip. p is 0 for a resistance in series with the pad, and 1 for a supply that is limited in current, whose slew
takes C V / I; supplies lie in between. The film's dipoles keep up with an edge that is slower than they are. Two
poles in a row are taken as one with the sum of the times.

What is in front of the pad slows every reversal of polarity, too, and the force averages over them: a pad that follows
a square wave of half period T with time constant t keeps 1 - tanh(x) / x of its mean square voltage, x = T / (2 t).
What only switches on and off slows none, so the time constant of reversals is that of the edges times a ratio."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics import laws
from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Both time constants grow by R C (V / V_0)^p; what that costs at reversals beyond the base's scales the force."""
    voltage = inputs.relative_voltage ** np.asarray(values["voltage_exponent"])
    lag = values["resistance"] * inputs.capacitance * voltage
    half = 0.5 / inputs.conditions.frequency
    slower = sockets.rise_time_constant + values["reversal_ratio"] * lag
    kept = laws.kept_mean_square(slower, half) / laws.kept_mean_square(sockets.rise_time_constant, half)
    return sockets.with_(
        force_factor=sockets.force_factor * kept,
        rise_time_constant=sockets.rise_time_constant + lag,
        fall_time_constant=sockets.fall_time_constant + lag,
        field_lag=sockets.field_lag + lag,
    )


EFFECT = Effect(
    name="slow_drive",
    role="candidate",
    stage="drive",
    action="adds",
    summary="extra series resistance: rise and fall grow with the pad's capacitance",
    parameters=(
        Parameter(
            "resistance",
            "ohm",
            (0.0, 5e7),
            0.0,
            Prior("halfnormal", 1e6),
            neutral=0.0,
            description="series resistance between the drive and the pad, at 300 V",
        ),
        Parameter(
            "voltage_exponent",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("uniform", 0.0, 1.0),
            description="0: a resistance, 1: a current limit",
        ),
        Parameter(
            "reversal_ratio",
            "1",
            (1e-4, 30.0),
            0.1,
            Prior("lognormal", 0.1, 2.0),
            description="lag at reversals of polarity, which costs force at high frequency, over that at on and off",
        ),
    ),
    reference=(
        "Hinchet & Shea, Adv. Mater. Technol. 5 (2020) 1900895, doi:10.1002/admt.201900895 (RC of a clutch); "
        "RC lag derived here"
    ),
    validity="reversals that the film is too slow to follow: it feels mean squares; capacitance of the closed pad",
    apply=apply,
    draw=lambda rng: {
        "resistance": float(np.exp(rng.uniform(np.log(2e5), np.log(5e6)))),
        "voltage_exponent": float(rng.uniform(0.0, 1.0)),
        "reversal_ratio": float(np.exp(rng.uniform(np.log(1e-3), 0.0))),
    },
)
