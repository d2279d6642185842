"""Parameters that belong to the data and not to the clutch: noises and spreads between trials, sources, runs."""

from __future__ import annotations

from collections.abc import Mapping

from eaclutch.physics.effect import Parameter, Prior


def _spread(name: str, unit: str, median: float, sd_log: float, description: str) -> Parameter:
    bounds = (median * 1e-4, median * 1e4)
    return Parameter(name, unit, bounds, median, Prior("lognormal", median, sd_log), None, description)


HYPERPARAMETERS: Mapping[str, Parameter] = {
    p.name: p
    for p in (
        _spread("capacitance_noise", "1", 0.006, 0.7, "relative sd of a single capacitance reading"),
        _spread("trial_spread", "m", 1.5e-7, 0.7, "sd of the gap between trials of one width"),
        _spread("width_spread", "m", 1.5e-7, 0.7, "sd of the gap between widths, beside the trials'"),
        _spread("spectrum_noise", "1", 0.3, 0.8, "sd of a single permittivity point"),
        _spread("source_spread", "1", 0.08, 0.7, "relative sd of permittivity between sources"),
        _spread("frequency_spread", "1", 0.005, 0.7, "relative sd of a burst's frequency beside its error"),
        _spread("damping_spread", "1", 0.08, 0.7, "relative sd of a burst's damping ratio beside its error"),
        _spread("session_spread", "1", 0.04, 0.8, "relative sd of the shear capacity between sessions"),
        _spread("condition_spread", "1", 0.03, 0.8, "relative sd of the shear capacity between conditions"),
        _spread("run_spread", "1", 0.04, 0.7, "relative sd of the shear capacity from run to run"),
    )
}
