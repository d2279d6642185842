"""Capillary bridges: a field draws water into narrow gaps, and what has condensed pulls beside the field and outlives
it. The pull is taken as a share of the electric one at the end of the hold, and fades after switch-off as a residual
field does. It knows no drive frequency, for water follows slowly; unlike surface adhesion it is not there without
voltage, and unlike trapped charge it takes nothing off the drive."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """force_factor (1 + g), g = pull (V / 300 V)^n, and of that g / (1 + g) is left at switch-off, for drain_time."""
    stronger = inputs.relative_voltage ** np.asarray(values["voltage_exponent"])
    pull = values["pull"] * stronger
    driven = sockets.with_(force_factor=sockets.force_factor * (1.0 + pull))
    return driven.with_residual_pull(pull / (1.0 + pull), values["drain_time"])


EFFECT = Effect(
    name="capillary_bridges",
    role="lookalike",
    stage="contact",
    action="adds",
    summary="water drawn in by the field: an attraction that grows with the voltage and outlives it",
    parameters=(
        Parameter(
            "pull",
            "1",
            (0.0, 5.0),
            0.0,
            Prior("halfnormal", 0.5),
            neutral=0.0,
            description="further pull over the electric one at 300 V at the end of the hold",
        ),
        Parameter(
            "drain_time",
            "s",
            (1e-4, 1e2),
            5e-3,
            Prior("lognormal", 5e-3, 1.5),
            description="decay of that pull after switch-off",
        ),
        Parameter(
            "voltage_exponent",
            "1",
            (-1.5, 2.0),
            0.0,
            Prior("normal", 0.0, 0.4),
            description="its share of the electric pull grows as the voltage to this power",
        ),
    ),
    reference=(
        "Gomez-Monivas et al., Phys. Rev. Lett. 91 (2003) 056101, doi:10.1103/PhysRevLett.91.056101 (water bridges "
        "made by a field); Butt & Kappl, Adv. Colloid Interface Sci. 146 (2009) 48, doi:10.1016/j.cis.2008.10.002; "
        "law derived here"
    ),
    validity="holds much longer than the water takes to gather; the pull fades with the gap as the electric one does",
    apply=apply,
    draw=lambda rng: {
        "pull": float(np.exp(rng.uniform(np.log(0.1), np.log(0.6)))),
        "drain_time": float(np.exp(rng.uniform(np.log(1e-3), np.log(0.03)))),
        "voltage_exponent": 0.0,
    },
)
