"""The zero of the load cell: the force before the tip meets the substrate, where a run shows it."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import FloatArray
from eaclutch.rig.columns_in_step import sample_spacing
from eaclutch.rig.estimate import Estimate
from eaclutch.rig.noise import noise_of

SMOOTHING = 0.02  # s, one period of the stage's steps
SHORTEST = 0.1  # s of rest that make a zero
CLEAR = 6.0  # standard deviations by which the friction stands above it
LARGEST = 0.2  # N: a load cell is not further off
# What is known of a zero that a run does not show (rig: tens of mN between sessions).
UNKNOWN_ZERO_SD = 0.025  # N
NO_ZERO = Estimate(0.0, 0.0, "no_zero")


def find_zero(time: FloatArray, force: FloatArray, on: float) -> Estimate:
    """Mean force [N] of a flat stretch at the run's start that ends in a rise to the friction before ``on`` [s].

    Most runs begin in contact: then 0 +- 0 with the reason ``no_zero``; absolute forces keep their zero (contract:
    observables), a ratio to one takes ``UNKNOWN_ZERO_SD`` into its uncertainty.
    """
    step = sample_spacing(time)
    before = force[: np.searchsorted(time, on)]
    width = max(3, round(SMOOTHING / step))
    noise = noise_of(before[-round(0.5 / step) :], step)
    if noise is None or len(before) < round(1.0 / step) or not np.isfinite(before).all():
        return NO_ZERO
    smooth = uniform_filter1d(before, width)
    friction = float(np.median(before[-round(0.5 / step) :]))
    sd = max(noise.white_sd / np.sqrt(width), float(noise.residual.std()) / 2.0)
    shortest = round(SHORTEST / step)
    low = float(np.median(before[:shortest]))
    if friction - low < max(CLEAR * sd, 0.01) or abs(low) > LARGEST:
        return NO_ZERO
    # flat until the force leaves it for good
    left = np.flatnonzero(np.abs(smooth - low) > 0.2 * (friction - low))
    end = int(left[0]) - width if len(left) else 0
    if end < shortest:
        return NO_ZERO
    flat = before[:end]
    blocks = flat[: end // width * width].reshape(-1, width).mean(axis=1)
    scatter = float(blocks.std(ddof=1))
    white = noise.white_sd / np.sqrt(width)
    slope = np.polyfit(np.arange(len(blocks)), blocks, 1)[0] * len(blocks)
    if scatter > 3.0 * white + 0.003 or abs(slope) > 0.15 * (friction - low):
        return NO_ZERO
    return Estimate(float(flat.mean()), (scatter if scatter > 1.5 * white else white) / np.sqrt(len(blocks)))
