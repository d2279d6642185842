"""The free swing of the load cell after release: frequency and damping ratio."""

from __future__ import annotations

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.run_view import RunView
from eaclutch.rig.swing import Swing, fit_swing

START, END = 0.004, 0.030  # s after the voltage fell


def swing(run: RunView) -> Swing:
    """The damped swing after release. Raises Unusable (``no_swing``)."""
    off = run.force_off
    window = run.window(off + START, off + END, least=60)
    noise = run.noise_rest
    together = noise.autocovariance(window.stop - window.start)
    found = fit_swing(run.time[window] - off, run.force[window], noise.white_sd, together)
    if found is None:
        raise Unusable("no_swing")
    return found


def _frequency(run: RunView) -> Estimate:
    found = run.once("swing", swing)
    return Estimate(found.frequency, found.frequency_sd)


def _damping(run: RunView) -> Estimate:
    found = run.once("swing", swing)
    return Estimate(found.damping_ratio, found.damping_ratio_sd)


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "ringdown_frequency_hz", "Hz", "ringdown", "of the free swing 4 to 30 ms after release"
        ),
        _frequency,
    ),
    Observable(
        ObservableInfo(
            "ringdown_damping_ratio", "1", "ringdown", "of the free swing 4 to 30 ms after release"
        ),
        _damping,
    ),
)
