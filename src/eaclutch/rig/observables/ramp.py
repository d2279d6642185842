"""Slope of the force after the voltage came on, in three windows: the ramp is concave."""

from __future__ import annotations

import math

import numpy as np

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView

FEWEST = 4  # samples beside the drive's edges, of which a slope is taken


def slope(run: RunView, start: float, end: float) -> Estimate:
    """Least-squares slope of the force [N/s] between two instants of the run's time [s]. Raises Unusable.

    Samples that show the drive's edges are bridged: a force that slips is no line, and its slope not that of a part.
    """
    window = run.window(start, end)
    seen = np.flatnonzero(~run.pick_up[window])
    if len(seen) < FEWEST:
        raise Unusable("too_short")
    known = slice(window.start + int(seen[0]), window.start + int(seen[-1]) + 1)
    time = run.time[known]
    force = np.interp(time, run.time[window][seen], run.force[window][seen])
    time = time - time.mean()
    weights = time / np.sum(time**2)
    return Estimate(float(weights @ force), run.noise_moving.sd(weights))


def _ramp(name: str, start: float, end: float) -> Observable:
    def measure(run: RunView) -> Estimate:
        run.require_in_step("on")
        on, step = run.events.on, run.step
        here, earlier, later = (slope(run, on + start + by, on + end + by) for by in (0.0, -step, step))
        shifted = 0.5 * (later.value - earlier.value) / step * run.events.on_sd
        return Estimate(here.value, math.hypot(here.sd, shifted))

    text = f"least-squares slope of the force {start * 1e3:g} to {end * 1e3:g} ms after voltage on"
    return Observable(ObservableInfo(name, "N/s", "ramp", text), measure)


OBSERVABLES = (
    _ramp("ramp_rate_n_s", 0.002, 0.020),
    _ramp("ramp_rate_early_n_s", 0.0005, 0.005),
    _ramp("ramp_rate_late_n_s", 0.050, 0.200),
)
