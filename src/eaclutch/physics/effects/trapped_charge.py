"""Trapped charge: while one polarity lasts, charge fills traps at the film's surface; what has been filled
outlives the drive as a residual field. Saturable filling over the time t_h that one polarity lasts,
q / q_max = t_h / (t_h + t_i), with t_h = 1 / (2 f) (never longer than the drive itself, which is the case of
DC) and the injection time t_i = 1 / (2 f_c), gives residual_fraction = a / (1 + f / f_c) for f well above
one over the drive. It decays as exp(-t / decay_time) after switch-off."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Residual field after switch-off: fraction a t_h / (t_h + t_i) of the drive's, and its decay."""
    conditions = inputs.conditions
    polarity_time = np.minimum(0.5 / conditions.frequency, conditions.drive_duration)
    injection_time = 0.5 / np.asarray(values["corner_frequency"])
    filled = polarity_time / (polarity_time + injection_time)
    return sockets.with_(
        residual_fraction=values["residual_fraction"] * filled, residual_decay_time=values["decay_time"]
    )


EFFECT = Effect(
    name="trapped_charge",
    role="candidate",
    stage="electrostatics",
    action="adds",
    summary="charge injected at low drive frequency leaves a residual field after switch-off",
    parameters=(
        Parameter(
            "residual_fraction",
            "1",
            (0.0, 0.98),
            0.0,
            Prior("halfnormal", 0.5),
            neutral=0.0,
            description="residual field over the drive's, just after a long single polarity",
        ),
        Parameter(
            "corner_frequency",
            "Hz",
            (0.1, 1e4),
            50.0,
            Prior("lognormal", 50.0, 1.5),
            description="drive frequency at which the traps are half filled",
        ),
        Parameter(
            "decay_time",
            "s",
            (1e-4, 1e3),
            0.02,
            Prior("lognormal", 0.02, 2.0),
            description="decay of the residual field",
        ),
    ),
    reference=(
        "Nakamura & Yamamoto, ROBOMECH J. 4 (2017) 18, doi:10.1186/s40648-017-0085-3 (interface charge under "
        "DC); filling law derived here"
    ),
    validity="charge of one sign a half wave; the driven force itself is left as it is",
    apply=apply,
    draw=lambda rng: {
        "residual_fraction": rng.uniform(0.4, 0.9),
        "corner_frequency": float(np.exp(rng.uniform(np.log(5.0), np.log(300.0)))),
        "decay_time": float(np.exp(rng.uniform(np.log(1e-3), np.log(1.0)))),
    },
)
