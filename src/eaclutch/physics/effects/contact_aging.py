"""Contact aging: mu_s(t) = mu_s (1 + b ln(1 + t / t_0)) with t the time at rest. In the driven ramp the strip
rests as long as the stage takes to load it (F / (k_lc v), with the force F at switch-off as the run's load); when the
voltage falls it has rested for the dwell of the stage and, on average, half a ramp."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

TYPICAL_LOAD = 1.0  # N, of a run whose force at switch-off is not known
SMALLEST_LOAD = 0.02  # N


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Static factors 1 + b ln(1 + t / t_0) for the ramp's rest and the rest at switch-off."""
    conditions = inputs.conditions
    force = conditions.switch_off_force
    load = np.where(np.isfinite(force), np.maximum(force, SMALLEST_LOAD), TYPICAL_LOAD)
    ramp = load / (inputs.parameters["stiffness"] * inputs.bench.stage_speed)
    ramp = np.minimum(ramp, conditions.drive_duration)
    rest = conditions.dwell + 0.5 * ramp
    rate, onset = values["rate"], np.asarray(values["onset_time"])
    return sockets.with_(
        static_factor_ramp=sockets.static_factor_ramp * (1.0 + rate * np.log1p(ramp / onset)),
        static_factor_release=sockets.static_factor_release * (1.0 + rate * np.log1p(rest / onset)),
    )


EFFECT = Effect(
    name="contact_aging",
    role="candidate",
    stage="friction",
    action="multiplies",
    summary="static friction grows with the logarithm of the time at rest",
    parameters=(
        Parameter(
            "rate",
            "1",
            (0.0, 0.5),
            0.0,
            Prior("halfnormal", 0.05),
            neutral=0.0,
            description="relative growth of static friction per e-fold of rest",
        ),
        Parameter(
            "onset_time",
            "s",
            (1e-3, 100.0),
            0.1,
            Prior("lognormal", 0.1, 1.5),
            description="rest after which the growth sets in",
        ),
    ),
    reference=("Dieterich, J. Geophys. Res. 77 (1972) 3690, doi:10.1029/JB077i020p03690"),
    validity="rests far above the onset; slips reset the age completely",
    apply=apply,
    draw=lambda rng: {
        "rate": rng.uniform(0.02, 0.15),
        "onset_time": float(np.exp(rng.uniform(np.log(0.02), np.log(0.5)))),
    },
)
