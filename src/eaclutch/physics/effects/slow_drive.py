"""Slow drive: what feeds the pad passes a current that goes as a power of the voltage across it, C dV/dt =
-(V_0 / R) (V / V_0)^(1 - p), V_0 = 300 V. An edge of V takes the time R C (V / V_0)^p with C the closed pad's
capacitance, so more the wider the strip, and is an exponential for p = 0, a resistance in series with the pad, and a
straight line for p = 1, a supply that is limited in current; supplies lie in between. The film's dipoles keep up with
an edge that is slower than they are. Beside the drive's own edge it is taken as one with the sum of the times, as
straight as the share of the slow one.

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

SHORTEST = 1e-12  # s; of an edge that is none


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Both time constants grow by R C (V / V_0)^p, and edges are as straight as p; what that costs at reversals beyond
    the base's scales the force."""
    power = np.asarray(values["voltage_exponent"])
    lag = values["resistance"] * inputs.capacitance * inputs.relative_voltage**power
    fall = sockets.fall_time_constant + lag
    half = 0.5 / inputs.conditions.frequency
    slower = sockets.rise_time_constant + values["reversal_ratio"] * lag
    kept = laws.kept_mean_square(slower, half) / laws.kept_mean_square(sockets.rise_time_constant, half)
    return sockets.with_(
        force_factor=sockets.force_factor * kept,
        edge_straightness=power * lag / np.maximum(fall, SHORTEST),
        rise_time_constant=sockets.rise_time_constant + lag,
        fall_time_constant=fall,
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
            description="0: a resistance, exponential edges; 1: a current limit, straight ones",
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
        "power law of the current derived here"
    ),
    validity="reversals that the film is too slow to follow: it feels mean squares, as of exponentials; capacitance of "
    "the closed pad",
    apply=apply,
    draw=lambda rng: {
        "resistance": float(np.exp(rng.uniform(np.log(2e5), np.log(5e6)))),
        "voltage_exponent": float(rng.uniform(0.0, 1.0)),
        "reversal_ratio": float(np.exp(rng.uniform(np.log(1e-3), 0.0))),
    },
)
