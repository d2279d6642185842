"""Onset of a rise in noisy force: a level, then a rise that may flatten, with the noise's own correlation."""

from __future__ import annotations

import numpy as np
from scipy.linalg import cholesky, solve_triangular, toeplitz
from scipy.special import log_ndtr

from eaclutch.records import FloatArray
from eaclutch.rig.estimate import Estimate
from eaclutch.rig.noise import Noise

BIN = 3  # samples that are averaged: a quarter of a millisecond, well below the resolution
FLATTENING = (np.inf, 0.015, 0.005)  # s: a straight rise and two that flatten, equally likely before
STEEPEST = 9.0  # N/s, scale of the slope's prior: a stage of 0.5 mm/s on 18 N/mm
GRID = 0.0002  # s


def onset(
    time: FloatArray,
    force: FloatArray,
    use: np.ndarray,
    noise: Noise,
    search: tuple[float, float],
    step_sd: float = 0.0,
) -> Estimate:
    """When the force begins to rise [s]: mean and sd over all onsets in ``search``, equally likely before.

    ``time`` [s], evenly spaced, ``force`` [N] and ``use`` (bool: samples that count) have shape (samples,). Level and
    slope (> 0) are integrated out, the latter with a Normal(0, STEEPEST^2) prior. The covariance is the noise's own,
    the stage's steps at 50 Hz included, so that a slow ripple widens the answer. ``step_sd`` [N]: by how much the
    force may step at time 0 without a rise (a drive that is seen in it).
    """
    count = len(time) // BIN * BIN
    time, force, use = (values[:count].reshape(-1, BIN) for values in (time, force, use.astype(bool)))
    kept = np.flatnonzero(use.all(axis=1))
    time, force = time.mean(axis=1)[kept], force.mean(axis=1)[kept]
    covariance = toeplitz(noise.binned(BIN).autocovariance(int(kept[-1]) + 1))[np.ix_(kept, kept)]
    driven = time > 0
    covariance = covariance + step_sd**2 * np.outer(driven, driven)
    root = cholesky(covariance, lower=True, check_finite=False)
    starts = np.arange(search[0], search[1] + GRID / 2, GRID)
    since = np.maximum(time[:, None] - starts, 0.0)
    rises = [since if np.isinf(tau) else tau * (1.0 - np.exp(-since / tau)) for tau in FLATTENING]
    columns = np.concatenate([force[:, None], np.ones((len(time), 1)), *rises], axis=1)
    white = solve_triangular(root, columns, lower=True, check_finite=False)
    data, level, shapes = white[:, 0], white[:, 1], white[:, 2:]
    power = level @ level
    shapes = shapes - np.outer(level, level @ shapes) / power
    data = data - level * (level @ data) / power
    precision = np.sum(shapes**2, axis=0) + STEEPEST**-2
    seen = data @ shapes
    log_weight = 0.5 * seen**2 / precision - 0.5 * np.log(precision) + log_ndtr(seen / np.sqrt(precision))
    weight = np.exp(log_weight - log_weight.max()).reshape(len(FLATTENING), -1).sum(axis=0)
    weight /= weight.sum()
    mean = float(weight @ starts)
    return Estimate(mean, float(np.sqrt(weight @ (starts - mean) ** 2)))
