"""Release times: how long the force takes from the fall of the voltage to 10, 50, 90 % of its way down."""

from __future__ import annotations

import math

import numpy as np

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.fall import over_pick_up, passing_times, smoothed, smoothing_weights
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

LOOK = 0.02  # s after the voltage fell in which the force must have gone its way
LEAST_DROP = 4.0  # standard deviations of one sample
DRAWS = 64
CLEAR = 0.1  # of the way: a level is passed for good when the force is that far below
REACH = 7  # samples after the pick-up that show how the fall begins
SHARES = (0.1, 0.5, 0.9)


def release_times(run: RunView) -> dict[float, Estimate]:
    """Time from voltage off [s] to each share of the way from the force at switch-off to the final one.

    The uncertainty, and the bias that is taken off, come from the run's own noise: windows of it are added to the
    smoothed force and go the same way.
    """
    run.require_in_step("off")
    events, noise = run.events, run.noise_rest
    start, final = run.switch_off_level, run.final_level
    drop = start.value - final.value
    if drop < LEAST_DROP * noise.white_sd:
        raise Unusable("no_release")
    weights = smoothing_weights(drop / noise.white_sd)
    window = run.window(events.off, events.off + LOOK)
    time, spoiled = run.time[window] - events.off, run.pick_up[window]

    def passing(force: np.ndarray, level: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        smooth = smoothed(over_pick_up(time, force, spoiled, level, REACH), weights, level)
        way = level - end
        shares = [passing_times(time, smooth, level - share * way, CLEAR * way) for share in SHARES]
        return smooth, np.stack(shares)

    level, end = np.array([start.value]), np.array([final.value])
    smooth, value = passing(run.force[None, window], level, end)
    _, again = passing(smooth, level, end)
    spread = noise.windows(len(time), DRAWS)
    quantiles = (np.arange(DRAWS) + 0.5) / DRAWS - 0.5
    drawn_start = start.value + start.sd * math.sqrt(12.0) * quantiles[(5 * np.arange(DRAWS)) % DRAWS]
    drawn_end = final.value + final.sd * math.sqrt(12.0) * quantiles[(11 * np.arange(DRAWS)) % DRAWS]
    _, drawn = passing(smooth + spread, drawn_start, drawn_end)
    found = {}
    for share, times, first, second in zip(SHARES, drawn, value[:, 0], again[:, 0], strict=True):
        times = times[np.isfinite(times)]
        if not (math.isfinite(first) and math.isfinite(second)) or len(times) < 0.9 * DRAWS:
            found[share] = Estimate.missing("no_release")
            continue
        bias = float(np.mean(times)) - second
        found[share] = Estimate(first - bias, math.hypot(float(np.std(times)), events.off_sd))
    return found


def _release(share: float) -> Observable:
    def measure(run: RunView) -> Estimate:
        return release_times(run)[share]

    text = (
        f"time from voltage off until the force has done {share * 100:g} % of its way from switch_off_force to "
        "final, interpolated between samples"
    )
    return Observable(ObservableInfo(f"release_time_{share * 100:g}_s", "s", "release", text), measure)


OBSERVABLES = tuple(_release(share) for share in SHARES)
