"""Film tension: the film is clamped beside the strip; drawn towards it by y it answers with a spring force
s y (1 + b y^2), s proportional to the overlap length: bending and pre-tension are linear, and stretching adds a cubic
part, which for a slack, thin film is the larger one. It is drawn from the gap that it leaves by itself: the preload has
drawn it down to h_before already where that is less, and the stretched film is stiffer there (y_before = h_free -
h_before); where it is wider the spring begins at h_before. Bent down beside the strip it does not matter how wide the
strip is; between spots under it the film is as stiff as it is wide; s grows as the width to a power in between. What
part of the preload it carries from the start cannot be seen: the preload is known from the friction before, which only
feels what reaches the strip. So only what the force grows by from y_before on counts."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.physics.effect import Effect, Inputs, Parameter, Prior
from eaclutch.physics.sockets import Sockets
from eaclutch.records import FloatArray


def apply(sockets: Sockets, inputs: Inputs, values: Mapping[str, FloatArray]) -> Sockets:
    """film_spring = s' L_s (w_s / w_0)^p, film_hardening = b, film_free_gap = h_free."""
    width = inputs.relative_width ** np.asarray(values["width_exponent"])
    return sockets.with_(
        film_spring=sockets.film_spring + values["stiffness"] * inputs.bench.pad.overlap_length * width,
        film_hardening=sockets.film_hardening + values["hardening"],
        film_free_gap=np.asarray(values["free_gap"]),
    )


EFFECT = Effect(
    name="film_tension",
    role="candidate",
    stage="film",
    action="adds",
    summary="the stretched, bent film carries part of the load",
    parameters=(
        Parameter(
            "stiffness",
            "N/m2",
            (0.0, 2e7),
            0.0,
            Prior("halfnormal", 1e6),
            neutral=0.0,
            description="restoring force per gap closed and overlap length, of a strip 2 mm wide",
        ),
        Parameter(
            "width_exponent",
            "1",
            (0.0, 1.0),
            0.0,
            Prior("uniform", 0.0, 1.0),
            description="0: bent beside the strip, 1: bent under it, all over its width",
        ),
        Parameter(
            "hardening",
            "1/m2",
            (0.0, 2e12),
            0.0,
            Prior("halfnormal", 3e11),
            neutral=0.0,
            description="share by which stretching adds to that, per gap closed squared",
        ),
        Parameter(
            "free_gap",
            "m",
            (0.0, 3e-5),
            0.0,
            Prior("normal", 6e-6, 4e-6),
            description="gap from which the film is drawn; one narrower than that before the voltage says nothing",
        ),
    ),
    reference=(
        "Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, doi:10.1016/j.eml.2025.102382 (clamped "
        "film of its bench); Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells (1959), ch. 13 (cubic "
        "stretching of clamped plates); lumped here"
    ),
    validity="gap changes small against the span of the film",
    apply=apply,
    draw=lambda rng: {
        "stiffness": float(np.exp(rng.uniform(np.log(1e5), np.log(1.5e6)))),
        "width_exponent": float(rng.uniform(0.0, 1.0)),
        "hardening": float(rng.uniform(0.0, 2e11)),
        "free_gap": float(rng.uniform(3e-6, 1.2e-5)),
    },
)
