"""Supply sag: a supply with an output resistance gives up voltage in proportion to the mean current that is drawn.
Every reversal takes the pad's charge, so the voltage falls to 1 / (1 + x) of its set value with x = 4 f R C for a
resistance, steeper or flatter than f for a supply that regulates. Unlike a slow drive it delays no edge. What its
output capacitor holds lasts for a while: part of the loss, or all, comes after the climb."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

REFERENCE_FREQUENCY = 1e4  # Hz


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """x = sag (f / 10 kHz)^n (w / w_0)^p; force_factor (1 + (1 - late) x)^-2, and (1 + x)^-2 with held_factor."""
    frequency = inputs.conditions.frequency / REFERENCE_FREQUENCY
    load = inputs.relative_width ** np.asarray(values["width_exponent"])
    x = values["sag"] * frequency ** np.asarray(values["frequency_exponent"]) * load
    soon = (1.0 - np.asarray(values["late_share"])) * x
    return sockets.with_(
        force_factor=sockets.force_factor / (1.0 + soon) ** 2,
        held_factor=sockets.held_factor * ((1.0 + soon) / (1.0 + x)) ** 2,
    )


EFFECT = Effect(
    name="supply_sag",
    role="lookalike",
    stage="drive",
    action="multiplies",
    summary="a supply that cannot hold its voltage: the force falls with the drive's frequency",
    parameters=(
        Parameter(
            "sag",
            "1",
            (0.0, 20.0),
            0.0,
            Prior("halfnormal", 0.3),
            neutral=0.0,
            description="lost over remaining voltage at 10 kHz on a 2 mm strip",
        ),
        Parameter(
            "frequency_exponent",
            "1",
            (0.3, 3.0),
            1.0,
            Prior("lognormal", 1.0, 0.4),
            description="1: an output resistance, whose loss grows as the frequency",
        ),
        Parameter(
            "width_exponent",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("uniform", 0.0, 1.0),
            description="1: all current charges the pad, 0: none of it does",
        ),
        Parameter(
            "late_share",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("uniform", 0.0, 1.0),
            description="of the loss, what comes after the force has climbed; 0: the voltage is low from the start",
        ),
    ),
    reference=(
        "Hinchet & Shea, Adv. Mater. Technol. 5 (2020) 1900895, doi:10.1002/admt.201900895 (charging currents of a "
        "clutch); mean current of a square wave derived here"
    ),
    validity="a loss that lasts as long as the drive does; nothing while the frequency is low",
    apply=apply,
    draw=lambda rng: {
        "sag": float(np.exp(rng.uniform(np.log(0.08), np.log(0.6)))),
        "frequency_exponent": float(rng.uniform(0.7, 2.0)),
        "width_exponent": float(rng.uniform(0.0, 1.0)),
        "late_share": float(rng.uniform(0.0, 1.0)),
    },
)
