"""Reading drift: the zero of the force moves while the drive is on, as that of an amplifier does that warms up, or of a
cell that creeps. The reading starts right and is off by rate x time when the voltage falls; each run starts anew."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import REFERENCE_VOLTAGE, Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """reading_drift = rate (V / 300 V)^n."""
    voltage = inputs.conditions.voltage / REFERENCE_VOLTAGE
    rate = values["rate"] * voltage ** np.asarray(values["voltage_exponent"])
    return sockets.with_(reading_drift=sockets.reading_drift + rate)


EFFECT = Effect(
    name="reading_drift",
    role="lookalike",
    stage="readout",
    action="adds",
    summary="a zero of the load cell that moves while the drive is on",
    parameters=(
        Parameter(
            "rate",
            "N/s",
            (-1.0, 1.0),
            0.0,
            Prior("normal", 0.0, 0.03),
            neutral=0.0,
            description="by which the reading rises at 300 V",
        ),
        Parameter(
            "voltage_exponent",
            "1",
            (0.0, 2.0),
            1.0,
            Prior("uniform", 0.0, 2.0),
            description="0: the drive's voltage does not matter, 2: its power does",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (their readout); "
        "drift derived here"
    ),
    validity="a steady rate while driven; the largest force is taken to fall two thirds into the drive",
    apply=apply,
    draw=lambda rng: {
        "rate": float(rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(np.log(0.01), np.log(0.08)))),
        "voltage_exponent": float(rng.uniform(0.0, 2.0)),
    },
)
