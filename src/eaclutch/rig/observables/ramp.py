"""Slope of the force after the voltage came on, in three windows: the ramp is concave."""

from __future__ import annotations

import numpy as np

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView


def slope(run: RunView, start: float, end: float) -> Estimate:
    """Least-squares slope of the force [N/s] between two instants of the run's time [s], the samples that show the
    drive's edges left out. Raises Unusable."""
    window = run.window(start, end)
    used = ~run.pick_up[window]
    time = np.where(used, run.time[window] - run.time[window][used].mean(), 0.0)
    weights = time / np.sum(time**2)
    return Estimate(float(weights @ run.force[window]), run.noise_moving.sd(weights))


def _ramp(name: str, start: float, end: float) -> Observable:
    def measure(run: RunView) -> Estimate:
        run.require_in_step("on")
        on = run.events.on
        return slope(run, on + start, on + end)

    text = f"least-squares slope of the force {start * 1e3:g} to {end * 1e3:g} ms after voltage on"
    return Observable(ObservableInfo(name, "N/s", "ramp", text), measure)


OBSERVABLES = (
    _ramp("ramp_rate_n_s", 0.002, 0.020),
    _ramp("ramp_rate_early_n_s", 0.0005, 0.005),
    _ramp("ramp_rate_late_n_s", 0.050, 0.200),
)
