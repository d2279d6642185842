"""Release times: how long the force takes from the fall of the voltage to 10, 50, 90 % of its way down."""

from __future__ import annotations

import math

import numpy as np

from eaclutch.records import FloatArray, ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.fall import over_pick_up, passing_times, smoothed, smoothing_weights
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

LOOK = 0.02  # s after the voltage fell in which the force must have gone its way
LEAD = 8  # samples before, at which the force stands at its level
LEAST_DROP = 4.0  # standard deviations of one sample
LEAST_LEVEL = 1.5  # standard deviations of the smoothed force between a level and the end of the way
DRAWS = 64
CLEAR = 0.1  # of the way: a level is passed for good when the force is that far below
BRIDGE = 0.04  # of the time under the pick-up: sd of a passing there, which the line across only guesses
EVEN = 1.08  # voltage falls evenly anywhere between two samples: 0.99 sd of that hold 57 %, of this 62 % of the times
SHARES = (0.1, 0.5, 0.9)


def release_times(run: RunView) -> dict[float, Estimate]:
    """Time from voltage off [s] to each share of the way from the force at switch-off to the final one.

    The uncertainty, and the bias that is taken off, come from the run's own noise: windows of it are added to the
    smoothed force and go the same way once more.
    """
    run.require_in_step("off")
    if run.off_doubt:
        raise Unusable("off_unsure")
    events, noise = run.events, run.noise_rest
    start, final = run.switch_off_level, run.final_level
    drop = start.value - final.value
    if drop < LEAST_DROP * noise.white_sd:
        raise Unusable("no_release")
    weights = smoothing_weights(drop / noise.white_sd)
    window = run.window(events.off - LEAD * run.step, events.off + LOOK)
    time = run.time[window] - events.off
    driven, hidden = time < 0, run.pick_up[window] & (time > 0)

    def passing(force: FloatArray, level: FloatArray, end: FloatArray) -> tuple[FloatArray, FloatArray]:
        known = np.where(driven, level[:, None], force)
        way = level - end
        smooth = smoothed(over_pick_up(time, known, hidden, way, noise.white_sd), weights, level)
        shares = [
            passing_times(time, smooth, level - share * way, CLEAR * way, near_end=1.0 - share <= CLEAR)
            for share in SHARES
        ]
        return smooth, np.stack(shares)

    smooth, passed = passing(run.force[None, window], np.array([start.value]), np.array([final.value]))
    even = math.sqrt(12.0) * ((np.arange(DRAWS) + 0.5) / DRAWS - 0.5)  # mean 0, sd 1
    level = start.value + start.sd * even[(5 * np.arange(DRAWS)) % DRAWS]
    end = final.value + final.sd * even[(11 * np.arange(DRAWS)) % DRAWS]
    _, drawn = passing(smooth + noise.windows(len(time), DRAWS), level, end)
    noise_left = noise.white_sd * math.sqrt(float(np.sum(weights**2)))
    under = _hidden_span(time, hidden)
    found = {}
    for share, times, first in zip(SHARES, drawn, passed[:, 0], strict=True):
        times = times[np.isfinite(times)]
        if min(share, 1.0 - share) * drop < LEAST_LEVEL * noise_left:
            found[share] = Estimate.missing("level_in_noise")
            continue
        if not math.isfinite(first) or len(times) < 0.9 * DRAWS:
            found[share] = Estimate.missing("no_release")
            continue
        # what smoothing and noise do once more to the smoothed force, they have done to it before
        value = max(0.0, 2.0 * first - float(np.mean(times)))
        bridge, by_off = 0.0, EVEN
        if under[0] < value < under[1]:
            bridge = BRIDGE * (under[1] - under[0])
            by_off *= _moved_by_off(time, smooth[0], start.value, under, value)
        found[share] = Estimate(value, math.hypot(float(np.std(times)), by_off * events.off_sd, bridge))
    return found


def _hidden_span(time: FloatArray, hidden: np.ndarray) -> tuple[float, float]:
    """From the last sample before the pick-up to the first after it [s]; empty where there is none."""
    index = np.flatnonzero(hidden)
    return (float(time[index[0] - 1]), float(time[index[-1] + 1])) if len(index) else (0.0, 0.0)


def _moved_by_off(
    time: FloatArray, force: FloatArray, start: float, under: tuple[float, float], value: float
) -> float:
    """By what share of an error of voltage off a passing under the pick-up moves (0 to 1).

    The parabola across starts where the voltage is taken to have fallen and ends at the first force seen again, which
    stands lower the earlier the voltage really fell: so an error moves the passing by less than itself.
    """
    end = int(np.searchsorted(time, under[1]))
    slope = (force[end] - force[end + 1]) / (time[end + 1] - time[end])
    fallen = start - force[end]
    if not fallen > 0.0:
        return 1.0
    return float(np.clip(0.5 * (value - under[0]) * slope / fallen, 0.0, 1.0))


def _release(share: float) -> Observable:
    def measure(run: RunView) -> Estimate:
        return run.once("release_times", release_times)[share]

    text = (
        f"time from voltage off until the force has done {share * 100:g} % of its way from switch_off_force to "
        "final, interpolated between samples"
    )
    return Observable(ObservableInfo(f"release_time_{share * 100:g}_s", "s", "release", text), measure)


OBSERVABLES = tuple(_release(share) for share in SHARES)
