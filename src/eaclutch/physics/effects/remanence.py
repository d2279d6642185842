"""Remanence: part of the film's polarisation stays when the voltage has gone, and relaxes in its own time. Dipoles turn
within a half wave, so what stays knows no drive frequency, unlike trapped charge; a film whose dipoles turn only in a
strong field keeps more of a strong one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import LARGEST_RESIDUAL, Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Residual field r = a (V / 300 V)^n of the drive's, whose square pulls, with decay_time."""
    stronger = inputs.relative_voltage ** np.asarray(values["voltage_exponent"])
    residual = np.minimum(values["residual_fraction"] * stronger, LARGEST_RESIDUAL)
    return sockets.with_residual_pull(residual**2, 0.5 * np.asarray(values["decay_time"]))


EFFECT = Effect(
    name="remanence",
    role="lookalike",
    stage="contact",  # after trapped charge, beside which it is left
    action="adds",
    summary="polarisation that stays: a residual field after switch-off at any drive frequency",
    parameters=(
        Parameter(
            "residual_fraction",
            "1",
            (0.0, LARGEST_RESIDUAL),
            0.0,
            Prior("halfnormal", 0.4),
            neutral=0.0,
            description="residual field over the drive's right after switch-off at 300 V",
        ),
        Parameter(
            "decay_time",
            "s",
            (1e-4, 1e3),
            0.01,
            Prior("lognormal", 0.01, 1.5),
            description="decay of the residual field",
        ),
        Parameter(
            "voltage_exponent",
            "1",
            (-0.5, 5.0),
            0.5,
            Prior("normal", 0.5, 0.7),
            description="the residual share of the drive's field grows as the voltage to this power",
        ),
    ),
    reference=(
        "Lovinger, Science 220 (1983) 1115, doi:10.1126/science.220.4602.1115 (ferroelectric polymers); law "
        "derived here"
    ),
    validity="dipoles that turn within a half wave and take part in the drive's permittivity",
    apply=apply,
    draw=lambda rng: {
        "residual_fraction": float(rng.uniform(0.3, 0.8)),
        "decay_time": float(np.exp(rng.uniform(np.log(1e-3), np.log(0.1)))),
        "voltage_exponent": float(rng.uniform(0.0, 2.0)),
    },
)
