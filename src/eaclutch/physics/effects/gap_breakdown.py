"""Gap breakdown: above a voltage the air in the gap discharges, and part of what the voltage grows by from there is
taken by charge on the film. The force then grows more slowly than with the square of the voltage, at any frequency."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray

ONSET_WIDTH = 10.0  # V; gaps are not all alike, so that discharges set in over such a range


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """force_factor (V' / V)^2, V' = V - lost w ln(1 + exp((V - onset) / w)), w = 10 V."""
    voltage = np.maximum(inputs.conditions.voltage, 1.0)
    beyond = ONSET_WIDTH * np.logaddexp(0.0, (voltage - np.asarray(values["onset"])) / ONSET_WIDTH)
    left = 1.0 - np.asarray(values["lost"]) * np.minimum(beyond / voltage, 1.0)
    return sockets.with_(force_factor=sockets.force_factor * left**2)


EFFECT = Effect(
    name="gap_breakdown",
    role="lookalike",
    stage="electrostatics",
    action="multiplies",
    summary="discharges in the air gap: above a voltage the force hardly grows",
    parameters=(
        Parameter(
            "lost",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("normal", 0.75, 0.25),
            neutral=0.0,
            description="share of what the voltage exceeds its onset by that the gap does not see",
        ),
        Parameter(
            "onset",
            "V",
            (50.0, 1000.0),
            250.0,
            Prior("normal", 250.0, 25.0),
            description="drive amplitude at which discharges set in",
        ),
    ),
    reference=(
        "Dhariwal, Torres & Desmulliez, IEE Proc. Sci. Meas. Technol. 147 (2000) 261, doi:10.1049/ip-smt:20000506 "
        "(breakdown of micrometre gaps in air); law derived here"
    ),
    validity="onset the same in all gaps; what charge is left on the film after switch-off is not counted",
    apply=apply,
    draw=lambda rng: {
        "lost": float(rng.uniform(0.3, 0.9)),
        "onset": float(rng.uniform(200.0, 270.0)),
    },
)
