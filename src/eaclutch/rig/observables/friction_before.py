"""Friction before the voltage: the force that slides the substrate, and so the preload."""

from __future__ import annotations

import math

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView


def _measure(run: RunView) -> Estimate:
    mean = run.friction_level
    return Estimate(mean.value - run.zero.value, math.hypot(mean.sd, run.zero.sd))


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "friction_before_n",
            "N",
            "before",
            "mean force over the 0.5 s before voltage on, less the zero (0 where no zero can be had)",
        ),
        _measure,
    ),
)
