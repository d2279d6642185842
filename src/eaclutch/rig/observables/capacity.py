"""Shear capacity: what the clutch holds at most while driven."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

SMOOTHING = 20 / 12800  # s: 20 samples of the rig


def peak(run: RunView) -> Estimate:
    """Largest smoothed force while driven [N], the zero not taken off. Raises Unusable."""
    window = run.window(run.force_on, run.force_off)
    width = max(1, round(SMOOTHING / run.step))
    smooth = uniform_filter1d(run.force[window], width)[width:-width]
    return Estimate(float(smooth.max()), run.noise_moving.sd(np.full(width, 1.0 / width)))


def _measure(run: RunView) -> Estimate:
    top, before = peak(run), run.force_before_on
    return Estimate(top.value - before.value, math.hypot(top.sd, before.sd))


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "shear_capacity_n",
            "N",
            "hold",
            "largest force while driven, smoothed over 20 samples, less the force just before voltage on",
        ),
        _measure,
    ),
)
