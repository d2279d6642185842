"""When a falling force passes given levels: local cubic smoothing, interpolation between samples."""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_coeffs

from eaclutch.records import FloatArray

BOTTOM = 0.0015  # s after a level is first passed in which the fall ends


def smoothing_weights(drop_over_noise: float) -> FloatArray:
    """Weights of a local cubic: wider where the drop stands less far out of the noise (bias against scatter)."""
    half = 3 if drop_over_noise > 20 else 4 if drop_over_noise > 10 else 6
    return savgol_coeffs(2 * half + 1, 3)


def smoothed(force: FloatArray, weights: FloatArray, level: FloatArray) -> FloatArray:
    """Local cubic of each force (draws, samples); before the first sample it stands at ``level`` (draws,)."""
    half = len(weights) // 2
    ahead = np.repeat(level[:, None], half, axis=1)
    behind = np.repeat(force[:, -1:], half, axis=1)
    padded = np.concatenate([ahead, force, behind], axis=1)
    return np.lib.stride_tricks.sliding_window_view(padded, len(weights), axis=1) @ weights[::-1]


def over_pick_up(
    time: FloatArray, force: FloatArray, spoiled: np.ndarray, level: FloatArray, reach: int
) -> FloatArray:
    """Forces (draws, samples) with the ``spoiled`` samples taken from a start of the fall, level - a t^2 - b t^3.

    ``time`` counts from the fall of the voltage; the ``reach`` samples after the spoiled ones give a and b.
    """
    if not spoiled.any():
        return force
    last = int(np.flatnonzero(spoiled)[-1])
    seen = slice(last + 1, last + 1 + reach)
    powers = np.stack([time**2, time**3], axis=1)
    solve = np.linalg.pinv(powers[seen])  # (2, reach)
    below = (force[:, seen] - level[:, None]) @ solve.T
    filled = force.copy()
    filled[:, spoiled] = np.minimum(level[:, None] + below @ powers[spoiled].T, level[:, None])
    return filled


def passing_times(time: FloatArray, force: FloatArray, levels: FloatArray, clear: FloatArray) -> FloatArray:
    """When each smoothed force (draws, samples) passes its ``levels`` (draws,) on the way down [s]; NaN if never.

    Noise makes a force pass a level several times: the mean of the first time and the last before the force is
    ``clear`` (draws,) below the level (or, where it never is, at its lowest soon after) favours neither.
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
    still = ~below & (index < end[:, None])
    last = count - 1 - np.argmax(still[:, ::-1], axis=1)
    times = 0.5 * (_between(time, force, levels, first) + _between(time, force, levels, last + 1))
    return np.where(found & still.any(axis=1), times, np.nan)


def _between(time: FloatArray, force: FloatArray, levels: FloatArray, index: np.ndarray) -> FloatArray:
    """Where the line between the samples index - 1 and index passes the level."""
    index = np.clip(index, 1, force.shape[1] - 1)
    rows = np.arange(len(force))
    high, low = force[rows, index - 1], force[rows, index]
    part = np.clip((high - levels) / np.where(high > low, high - low, np.inf), 0.0, 1.0)
    return time[index - 1] + part * (time[index] - time[index - 1])
