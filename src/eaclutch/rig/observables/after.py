"""What is left after release."""

from __future__ import annotations

import math

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView


def _final(run: RunView) -> Estimate:
    final = run.final_level
    return Estimate(final.value - run.zero.value, math.hypot(final.sd, run.zero.sd))


def _shift(run: RunView) -> Estimate:
    final, before = run.final_level, run.friction_level
    return Estimate(final.value - before.value, math.hypot(final.sd, before.sd))


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "final_force_n", "N", "after", "mean force 10 to 110 ms after voltage off, less the zero"
        ),
        _final,
    ),
    Observable(
        ObservableInfo("baseline_shift_n", "N", "after", "final_force_n less friction_before_n"), _shift
    ),
)
