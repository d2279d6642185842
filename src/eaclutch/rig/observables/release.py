"""Release times: how long the force takes from the fall of the voltage to 10, 50, 90 % of its way down."""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import savgol_coeffs

from eaclutch.records import FloatArray, ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

LOOK = 0.06  # s after the voltage fell in which the force must have gone its way
LEAD = 0.003  # s before, from which the level at switch-off is taken
LEAST_DROP = 4.0  # standard deviations of one sample
DRAWS = 96


def smoothing(drop_over_noise: float) -> FloatArray:
    """Weights of the local cubic: wider where the drop stands less far out of the noise (bias against scatter)."""
    half = 3 if drop_over_noise > 20 else 4 if drop_over_noise > 10 else 6
    return savgol_coeffs(2 * half + 1, 3)


def first_crossings(time: FloatArray, force: FloatArray, level: FloatArray, start: float) -> FloatArray:
    """First instant after ``start`` at which each smoothed force (draws, samples) falls through ``level`` (draws,).

    Interpolated between samples; NaN where it never does.
    """
    below = (force < level[:, None]) & (time > start)
    index = np.argmax(below, axis=1)
    found = below.any(axis=1) & (index > 0)
    index = np.where(found, index, 1)
    rows = np.arange(len(force))
    high, low = force[rows, index - 1], force[rows, index]
    part = np.clip((high - level) / np.where(high > low, high - low, np.inf), 0.0, 1.0)
    part = np.where(high <= level, 1.0, part)
    crossing = time[index - 1] + part * (time[index] - time[index - 1])
    return np.where(found, np.maximum(crossing, start), np.nan)


def release_times(run: RunView) -> dict[float, Estimate]:
    """Time from voltage off [s] to each share of the way from the force at switch-off to the final one."""
    events, noise = run.events, run.noise_rest
    start, final = run.switch_off_level, run.final_level
    drop = start.value - final.value
    if drop < LEAST_DROP * noise.white_sd:
        raise Unusable("no_release")
    weights = smoothing(drop / noise.white_sd)
    window = run.window(events.off - LEAD, events.off + LOOK)
    time, force = run.time[window], run.force[window]
    fallen = int(np.searchsorted(time, events.off))
    half = len(weights) // 2
    # the force rests until the voltage falls: a cubic across that corner would round it
    padded = np.concatenate([np.full(half, start.value), force, np.full(half, force[-half:].mean())])
    smooth = np.convolve(padded, weights[::-1], mode="valid")
    noise_drawn = noise.windows(len(force), DRAWS)
    drawn_start = start.value + np.median(noise_drawn[:, :fallen], axis=1)
    drawn_final = (
        final.value + final.sd * np.sqrt(3.0) * np.linspace(-1, 1, DRAWS)[(37 * np.arange(DRAWS)) % DRAWS]
    )
    spread = np.apply_along_axis(np.convolve, 1, noise_drawn, weights[::-1], "same") + smooth
    out = {}
    for share in (0.1, 0.5, 0.9):
        level = start.value - share * drop
        value = first_crossings(time, smooth[None], np.array([level]), events.off)[0] - events.off
        levels = drawn_start - share * (drawn_start - drawn_final)
        drawn = first_crossings(time, spread, levels, events.off) - events.off
        drawn = drawn[np.isfinite(drawn)]
        if not math.isfinite(value) or len(drawn) < 0.9 * DRAWS:
            out[share] = Estimate.missing("no_release")
            continue
        out[share] = Estimate(float(value), math.hypot(float(np.std(drawn)), events.off_sd))
    return out


def _release(share: float) -> Observable:
    def measure(run: RunView) -> Estimate:
        return release_times(run)[share]

    text = (
        f"time from voltage off until the force has done {share * 100:g} % of its way from switch_off_force to "
        "final, interpolated between samples"
    )
    return Observable(ObservableInfo(f"release_time_{share * 100:g}_s", "s", "release", text), measure)


OBSERVABLES = tuple(_release(share) for share in (0.1, 0.5, 0.9))
