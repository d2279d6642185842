"""Shear capacity: what the clutch holds at most while driven."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

SMOOTHING = 20 / 12800  # s: 20 samples of the rig


def peak(run: RunView) -> Estimate:
    """Largest smoothed force while driven [N], the zero not taken off. Raises Unusable.

    The largest of many noisy means is too large. One half of the samples saying where it is and the other how large
    misses the top of a sharp peak and is too small. The truth lies between, and is taken to be anywhere there.
    """
    window = run.window(run.force_on, run.force_off, whole=False)
    half = max(1, round(SMOOTHING / run.step / 2))
    force = run.force[window]
    force = force[
        np.isfinite(force)
    ]  # the hole that lost lines leave hides the peak only if it lies right there
    count = len(force) // 2
    if count < 4 * half:
        raise Unusable("too_short")
    first, second = (uniform_filter1d(part[:count], half)[half:-half] for part in (force[::2], force[1::2]))
    held = 0.5 * (second[int(np.argmax(first))] + first[int(np.argmax(second))])
    largest = uniform_filter1d(force, 2 * half)[2 * half : -2 * half].max()
    noise = run.noise_moving.sd(np.full(2 * half, 0.5 / half))
    return Estimate(
        float(0.5 * (held + largest)),
        math.hypot(noise, (largest - held) / math.sqrt(12.0), run.drive_offset_sd),
    )


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
