"""Stick-slip while driven: how much of the force the largest slip lets go."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

SIDE = 0.0015  # s of mean force on either side of a slip
DURATION = 0.002  # s: a slip lasts about half a period of the load cell (0.8 ms)
THRESHOLD = 7.0  # standard deviations of the difference of two such means


def _measure(run: RunView) -> Estimate:
    run.require_unbroken_hold()
    events = run.events
    window = run.window(events.on + 0.001, events.off - 0.001)
    force = run.force[window]
    side = max(3, round(SIDE / run.step))
    lag = side + max(1, round(DURATION / run.step))
    smooth = uniform_filter1d(force, side)
    drops = smooth[:-lag] - smooth[lag:]
    weights = np.zeros(side + lag)
    weights[:side], weights[-side:] = 1.0 / side, -1.0 / side
    sd = run.noise_moving.sd(weights)
    largest = int(np.argmax(drops))
    if drops[largest] < THRESHOLD * sd:
        raise Unusable("no_slip")
    before = smooth[largest] - run.zero.value
    if before < THRESHOLD * sd:
        raise Unusable("no_slip")
    return Estimate(float(drops[largest] / before), float(sd / before))


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "slip_fraction",
            "1",
            "hold",
            "largest drop in one slip (within 2 ms) while driven over the force before that slip",
        ),
        _measure,
    ),
)
