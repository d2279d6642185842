"""Engagement time: onset of the force rise after the voltage came on. The rig resolves about a millisecond."""

from __future__ import annotations

import numpy as np

from eaclutch.records import FloatArray, ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

BEFORE, AFTER = 0.020, 0.020  # s around voltage on
PICK_UP = (-0.0001, 0.0005)  # s around voltage on in which the drive is seen in the force
ONSETS = np.arange(-0.004, 0.0141, 0.0002)  # s after voltage on


def onset(time: FloatArray, force: FloatArray, noise_sd: float) -> Estimate:
    """Onset [s] of a level that turns into a quadratic rise; ``time`` counts from voltage on.

    The posterior mean and sd over the onset, all of ``ONSETS`` being equally likely before; the levels and slopes
    are solved for at each.
    """
    costs = []
    for start in ONSETS:
        rise = np.maximum(time - start, 0.0)
        basis = np.stack([np.ones_like(time), rise, rise**2], axis=1)
        weights, *_ = np.linalg.lstsq(basis, force, rcond=None)
        costs.append(np.sum((force - basis @ weights) ** 2) / noise_sd**2)
    weight = np.exp(-0.5 * (np.array(costs) - np.min(costs)))
    weight /= weight.sum()
    mean = float(weight @ ONSETS)
    return Estimate(mean, float(np.sqrt(weight @ (ONSETS - mean) ** 2)))


def _measure(run: RunView) -> Estimate:
    on = run.events.on
    window = run.window(on - BEFORE, on + AFTER)
    time, force = run.time[window] - on, run.force[window]
    quiet = (time < PICK_UP[0]) | (time > PICK_UP[1])
    rise = force[time > 0.015].mean() - force[time < 0].mean()
    if rise < 4.0 * run.noise_moving.white_sd / np.sqrt(40):
        raise Unusable("no_rise")
    sd = float(np.sqrt(np.mean(run.noise_moving.residual**2)))
    return onset(time[quiet], force[quiet], max(sd, run.noise_moving.white_sd))


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "engagement_time_s",
            "s",
            "engage",
            "onset of the force rise after voltage on: level that turns into a quadratic rise, fitted over +-20 ms",
            resolution=1e-3,
        ),
        _measure,
    ),
)
