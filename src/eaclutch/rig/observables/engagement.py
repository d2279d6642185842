"""Engagement time: onset of the force rise after the voltage came on. The rig resolves about a millisecond."""

from __future__ import annotations

import math

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.onset import onset
from eaclutch.rig.run_view import RunView

BEFORE, AFTER = 0.020, 0.012  # s around voltage on
SEARCH = (-0.006, 0.009)  # s after voltage on
UNRESOLVED = 0.0035  # s: a posterior this wide is the search range again


def _measure(run: RunView) -> Estimate:
    run.require_in_step("on")
    on = run.events.on
    window = run.window(on - BEFORE, on + AFTER)
    time, force = run.time[window] - on, run.force[window]
    found = onset(time, force, ~run.pick_up[window], run.noise_moving, SEARCH)
    if found.sd > UNRESOLVED:
        raise Unusable("no_rise")
    return Estimate(found.value, math.hypot(found.sd, run.events.on_sd))


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "engagement_time_s",
            "s",
            "engage",
            "onset of the force rise after voltage on: level, then a rise that may flatten, fitted from 20 ms before "
            "to 12 ms after; mean over all onsets from 6 ms before to 9 ms after",
            resolution=1e-3,
        ),
        _measure,
    ),
)
