"""Contact aging: mu_s(t) = mu_s (1 + b g(1 + t / t_0)) with t the time at rest and g(x) = (x^n - 1) / n: the logarithm
at n = 0 (Dieterich), a power of time above (contacts that creep like a viscous solid), a growth that ends below (their
creep is used up). In the driven ramp the strip rests as long as the stage takes to load it (F / (k_lc v), with the
force F at switch-off as the run's load); when the voltage falls it has rested for the dwell of the stage and, on
average, half a ramp."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

TYPICAL_LOAD = 1.0  # N, of a run whose force at switch-off is not known
SMALLEST_LOAD = 0.02  # N


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Static factors 1 + b g(1 + t / t_0) for the ramp's rest and the rest at switch-off."""
    conditions = inputs.conditions
    force = conditions.switch_off_force
    load = np.where(np.isfinite(force), np.maximum(force, SMALLEST_LOAD), TYPICAL_LOAD)
    ramp = load / (inputs.parameters["stiffness"] * inputs.bench.stage_speed)
    ramp = np.minimum(ramp, conditions.drive_duration)
    rest = conditions.dwell + 0.5 * ramp
    rate, onset, power = (np.asarray(values[name]) for name in ("rate", "onset_time", "exponent"))
    return sockets.with_(
        static_factor_ramp=sockets.static_factor_ramp * (1.0 + rate * _grown(ramp / onset, power)),
        static_factor_release=sockets.static_factor_release * (1.0 + rate * _grown(rest / onset, power)),
    )


def _grown(age: FloatArray, power: FloatArray) -> FloatArray:
    """((1 + age)^n - 1) / n, ln(1 + age) at n = 0; broadcasts."""
    logarithm = np.log1p(age)
    known = np.where(power == 0.0, 1.0, power)
    found: FloatArray = np.where(power == 0.0, logarithm, np.expm1(known * logarithm) / known)
    return found


EFFECT = Effect(
    name="contact_aging",
    role="candidate",
    stage="friction",
    action="multiplies",
    summary="static friction grows with the logarithm, or a small power, of the time at rest",
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
        Parameter(
            "exponent",
            "1",
            (-1.0, 1.0),
            0.0,
            Prior("normal", 0.0, 0.15),
            description="of time; 0 is logarithmic growth, below it one that ends",
        ),
    ),
    reference=(
        "Dieterich, J. Geophys. Res. 77 (1972) 3690, doi:10.1029/JB077i020p03690 (logarithm); Baumberger & Caroli, "
        "Adv. Phys. 55 (2006) 279, doi:10.1080/00018730600732186 (creep of the contacts); exponent derived here"
    ),
    validity="rests far above the onset; slips reset the age completely",
    apply=apply,
    draw=lambda rng: {
        "rate": rng.uniform(0.02, 0.15),
        "onset_time": float(np.exp(rng.uniform(np.log(0.02), np.log(0.5)))),
        "exponent": rng.uniform(-0.2, 0.2),
    },
)
