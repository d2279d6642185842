"""Trapped charge: while one polarity lasts, charge fills traps at the film's surface; what has been filled outlives the
drive as a residual field. Saturable filling over the time t_h that one polarity lasts, q / q_max = t_h / (t_h + t_i),
with t_h = 1 / (2 f) (never longer than the drive itself, which is the case of DC) and the injection time t_i = 1 / (2
f_c), gives a residual field r = a / (1 + f / f_c) of the drive's for f well above one over the drive. The field that
is left need not grow as the drive's: charge that fills all traps leaves the same at any voltage, and injection that
needs a field leaves more than in proportion, so a goes as V^q. It decays as exp(-t / decay_time) after switch-off.
Charge of the electrode's own sign (homocharge) takes the same field off the drive while it lasts: the film is pulled
by 1 - s r of it, where s is 1 for a charge that sits there all the time and 0 for one that the force does not feel
before switch-off."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import LARGEST_RESIDUAL, Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """Residual field r = a (V / V_0)^q t_h / (t_h + t_i) of the drive's, its decay, and force_factor (1 - s r)^2 while
    driven."""
    injection_time = 0.5 / np.asarray(values["corner_frequency"])
    filled = inputs.polarity_time / (inputs.polarity_time + injection_time)
    stronger = inputs.relative_voltage ** np.asarray(values["voltage_exponent"])
    residual = np.minimum(values["residual_fraction"] * stronger * filled, LARGEST_RESIDUAL)
    driven = 1.0 - np.asarray(values["screening"]) * residual
    return sockets.with_(
        force_factor=sockets.force_factor * driven**2,
        # of the field that is released
        residual_fraction=np.minimum(residual / driven, LARGEST_RESIDUAL),
        residual_decay_time=values["decay_time"],
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
            (0.0, LARGEST_RESIDUAL),
            0.0,
            Prior("halfnormal", 0.5),
            neutral=0.0,
            description="residual field over the drive's, just after a long single polarity at 300 V",
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
        Parameter(
            "voltage_exponent",
            "1",
            (-1.5, 2.0),
            0.0,
            Prior("normal", 0.0, 0.5),
            description="the residual share of the drive's field grows as the voltage to this power",
        ),
        Parameter(
            "screening",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("halfnormal", 0.5),
            description="share of the residual field that the charge takes off the drive while it lasts",
        ),
    ),
    reference=(
        "Nakamura & Yamamoto, ROBOMECH J. 4 (2017) 18, doi:10.1186/s40648-017-0085-3 (interface charge under "
        "DC); Dissado & Fothergill, Electrical Degradation and Breakdown in Polymers (1992), ch. 10 (homocharge); "
        "filling law derived here"
    ),
    validity="charge of one sign a half wave, which weakens the drive from its start or not at all",
    apply=apply,
    draw=lambda rng: {
        "residual_fraction": rng.uniform(0.4, 0.9),
        "corner_frequency": float(np.exp(rng.uniform(np.log(5.0), np.log(300.0)))),
        "decay_time": float(np.exp(rng.uniform(np.log(1e-3), np.log(1.0)))),
        "voltage_exponent": 0.0,
        "screening": 0.3,  # neither is drawn: what recipes draw after this effect stays as it was
    },
)
