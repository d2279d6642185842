"""Engagement time: onset of the force rise after the voltage came on. The rig resolves about a millisecond."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.onset import onset
from eaclutch.rig.run_view import RunView

BEFORE, AFTER = 0.020, 0.012  # s around voltage on
SEARCH = (-0.006, 0.009)  # s after voltage on
SMOOTHING = 8  # samples
SLIP = 6.0  # standard deviations that the force falls where it slips
SHORTEST = 0.003  # s of rise
UNRESOLVED = 0.0035  # s: a posterior this wide is the search range again


def _end_of_rise(run: RunView, on: float) -> float:
    """Until when the force may rise [s]: AFTER, or the first slip. Raises Unusable (``slips_at_once``)."""
    window = run.window(on, on + AFTER)
    smooth = uniform_filter1d(run.force[window], SMOOTHING, mode="nearest")
    fallen = np.maximum.accumulate(smooth) - smooth
    slipped = np.flatnonzero(fallen > SLIP * run.noise_moving.white_sd / math.sqrt(SMOOTHING / 2))
    if len(slipped) == 0:
        return on + AFTER
    top = window.start + int(np.argmax(smooth[: slipped[0]]))
    if run.time[top] - on < SHORTEST:
        raise Unusable("slips_at_once")
    return float(run.time[top]) - SMOOTHING / 2 * run.step


def _measure(run: RunView) -> Estimate:
    run.require_in_step("on")
    on = run.events.on
    window = run.window(on - BEFORE, _end_of_rise(run, on))
    time, force = run.time[window] - on, run.force[window]
    found = onset(time, force, ~run.pick_up[window], run.noise_moving, SEARCH, run.drive_offset_sd)
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
            "to 12 ms after (to the first slip); mean over all onsets from 6 ms before to 9 ms after",
            resolution=1e-3,
        ),
        _measure,
    ),
)
