"""When a falling force passes given levels: local cubic smoothing, interpolation between samples."""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_coeffs

from eaclutch.records import FloatArray

BOTTOM = 0.0015  # s after a level is first passed in which the fall ends
# Share of the way, done behind the pick-up, from which on a fall may flatten there, and does.
MOST = (0.5, 0.75)
STAYS = 0.0003  # s below a level near the fall's end, after which another passing is none of the fall


def smoothing_weights(drop_over_noise: float) -> FloatArray:
    """Weights of a local cubic: wider where the drop stands less far out of the noise (bias against scatter)."""
    half = 2 if drop_over_noise > 12 else 3 if drop_over_noise > 7 else 5
    return np.ones(1) if drop_over_noise > 25 else savgol_coeffs(2 * half + 1, 3)


def smoothed(force: FloatArray, weights: FloatArray, level: FloatArray) -> FloatArray:
    """Local cubic of each force (draws, samples); before the first sample it stands at ``level`` (draws,)."""
    half = len(weights) // 2
    if half == 0:
        return force
    ahead = np.repeat(level[:, None], half, axis=1)
    behind = np.repeat(force[:, -1:], half, axis=1)
    padded = np.concatenate([ahead, force, behind], axis=1)
    return np.lib.stride_tricks.sliding_window_view(padded, len(weights), axis=1) @ weights[::-1]


def over_pick_up(
    time: FloatArray, force: FloatArray, spoiled: np.ndarray, way: FloatArray, noise_sd: float
) -> FloatArray:
    """Forces (draws, samples) with ``spoiled`` samples (samples,) bridged, one before and two behind them being sound;
    ``time`` (samples,) [s].

    Just after the voltage fell the force has hardly begun to fall: a parabola that leaves the left neighbour level.
    A fast load cell has done most of its ``way`` (draws,) [N] before it is seen again, and falls less steeply by then:
    the cubic term that the two samples behind show is added, less what of it ``noise_sd`` [N] may be.
    """
    index = np.flatnonzero(spoiled)
    if not len(index):
        return force
    left, behind = index[0] - 1, index[-1] + 1
    early, late = (float(time[behind + i] - time[left]) for i in (0, 1))
    fallen, then = (force[:, left] - force[:, behind + i] for i in (0, 1))
    cubic = np.minimum((then / late**2 - fallen / early**2) / (late - early), 0.0)
    variance = (noise_sd / (late - early)) ** 2 * (early**-4 + late**-4)
    cubic = cubic * np.maximum(1.0 - variance / np.maximum(cubic**2, variance), 0.0)
    cubic = cubic * np.clip((fallen / way - MOST[0]) / (MOST[1] - MOST[0]), 0.0, 1.0)
    at = time[index] - time[left]
    filled = force.copy()
    filled[:, index] = force[:, left, None] - at**2 * (
        fallen[:, None] / early**2 + cubic[:, None] * (at - early)
    )
    return filled


def passing_times(
    time: FloatArray, force: FloatArray, levels: FloatArray, clear: FloatArray, *, near_end: bool = False
) -> FloatArray:
    """When each smoothed force (draws, samples) passes its ``levels`` (draws,) on the way down [s]; NaN if never.

    Noise makes a force pass a level several times: the mean of the first time and the last before the force is
    ``clear`` (draws,) below the level (or, where it never is, at its lowest soon after) favours neither. ``near_end``:
    a fall that ends no further below may touch the level again; once it has stayed below for a while it has passed.
    """
    count = force.shape[1]
    index = np.arange(count)
    below = force < levels[:, None]
    first = np.argmax(below, axis=1)
    found = below.any(axis=1) & (first > 0)
    soon = first[:, None] + round(BOTTOM / float(time[1] - time[0]))
    lowest = np.argmin(np.where((index >= first[:, None]) & (index <= soon), force, np.inf), axis=1)
    far = force < (levels - clear)[:, None]
    end = np.where(far.any(axis=1), np.minimum(np.argmax(far, axis=1), lowest), lowest)
    if near_end:
        stays = max(2, round(STAYS / float(time[1] - time[0])))
        padded = np.pad(below, ((0, 0), (0, stays - 1)))
        ahead = np.all(np.lib.stride_tricks.sliding_window_view(padded, stays, axis=1), axis=2)
        end = np.where(np.any(ahead, axis=1), np.minimum(end, np.argmax(ahead, axis=1)), end)
    still = ~below & (index < end[:, None])
    last = count - 1 - np.argmax(still[:, ::-1], axis=1)
    times = 0.5 * (_between(time, force, levels, first) + _between(time, force, levels, last + 1))
    return np.where(found & still.any(axis=1), times, np.nan)


def _between(time: FloatArray, force: FloatArray, levels: FloatArray, index: np.ndarray) -> FloatArray:
    """Where the curve between the samples index - 1 and index passes the level, by inverse interpolation.

    The line, corrected once by the curvature that the two samples beyond show.
    """
    index = np.clip(index, 1, force.shape[1] - 1)
    rows = np.arange(len(force))
    high, low = force[rows, index - 1], force[rows, index]
    fall = np.where(high > low, high - low, np.inf)
    part = np.clip((high - levels) / fall, 0.0, 1.0)
    outer = force[rows, np.maximum(index - 2, 0)] + force[rows, np.minimum(index + 1, force.shape[1] - 1)]
    bend = np.clip((outer - high - low) / 4.0 / fall, -0.5, 0.5)  # half the second difference over the fall
    part = np.clip(part - bend * part * (1.0 - part), 0.0, 1.0)
    return time[index - 1] + part * (time[index] - time[index - 1])
