"""What the diagnosis makes of each observable: its scale, its phase, and whether it may carry a name.

A *channel* is one observable as the comparison sees it: by its logarithm, so that a law that is wrong by a factor is
wrong by the same amount everywhere, or divided by ``unit_scale``, so that 0.05 means the same everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from eaclutch.records import Bench, FloatArray

Scale = Literal["log", "linear"]
RAMP_RATE = 9.009  # N/s, and
QUARTER_PERIOD = 0.388e-3  # s: of the published rig, on which CHANNELS' units are those stated


@dataclass(frozen=True)
class Channel:
    """An observable in the comparison.

    block: channels of one block share their session effect and their model-form tolerance in part.
    unit_scale: what counts as 1 on the comparison scale (linear channels only; in the observable's unit).
    resolvable: False where the rig cannot tell what the observable is named after: such a channel takes no part
    in the comparison, and never carries a name. window_end [s]: end of a ramp's window after voltage on; a run
    that slips before it measures its slips, not its ramp, and does not count.
    """

    name: str
    unit: str
    phase: str
    block: str
    scale: Scale
    unit_scale: float = 1.0
    resolvable: bool = True
    window_end: float | None = None

    def forward(self, values: ArrayLike) -> FloatArray:
        """To the comparison scale (dimensionless); not-a-number where a logarithm does not exist."""
        values = np.asarray(values, dtype=float)
        if self.scale == "linear":
            return values / self.unit_scale
        return np.log(np.where(values > 0, values, np.nan))

    def forward_sd(self, values: ArrayLike, sd: ArrayLike) -> FloatArray:
        """Standard uncertainty on the comparison scale (first order)."""
        values, sd = np.asarray(values, dtype=float), np.asarray(sd, dtype=float)
        if self.scale == "linear":
            return sd / self.unit_scale
        return sd / np.where(values > 0, values, np.nan)

    def backward(self, scaled: ArrayLike) -> FloatArray:
        """From the comparison scale to the observable's own unit."""
        scaled = np.asarray(scaled, dtype=float)
        return scaled * self.unit_scale if self.scale == "linear" else np.exp(scaled)


# Times and rates are linear in units of what the rig typically shows: a time near zero has no logarithm, and
# leaving it out because of its sign would bias the rest. The final force is the baseline shift plus the
# friction before, which the model is given, so only the shift counts. Three carry no name: engagement, which
# the rig cannot resolve; the late ramp, for its
# window is so long that a slip falls into it for one set of parameters and not for the next; the ring-down, for the
# model's is that of the bare tip, and a strip that touches the tip while it swings makes it another oscillator.
CHANNELS: tuple[Channel, ...] = (
    Channel("engagement_time_s", "s", "engage", "engage", "linear", 1e-3, resolvable=False),
    Channel("ramp_rate_early_n_s", "N/s", "ramp", "ramp", "linear", 9.0, window_end=5e-3),
    Channel("ramp_rate_n_s", "N/s", "ramp", "ramp", "linear", 9.0, window_end=20e-3),
    Channel("ramp_rate_late_n_s", "N/s", "ramp", "ramp", "linear", 9.0, resolvable=False, window_end=200e-3),
    Channel("shear_capacity_n", "N", "ramp", "capacity", "log"),
    Channel("slip_fraction", "1", "hold", "slip", "linear", 1.0),
    Channel("hold_creep_n_s", "N/s", "hold", "creep", "linear", 0.1),
    Channel("release_time_10_s", "s", "release", "release", "linear", 5e-4),
    Channel("release_time_50_s", "s", "release", "release", "linear", 5e-4),
    Channel("release_time_90_s", "s", "release", "release", "linear", 5e-4),
    Channel("ringdown_frequency_hz", "Hz", "ringdown", "ringdown", "log", resolvable=False),
    Channel("ringdown_damping_ratio", "1", "ringdown", "ringdown", "linear", 0.1, resolvable=False),
    Channel("baseline_shift_n", "N", "after", "after", "linear", 0.1),
)


def channels_on(bench: Bench) -> tuple[Channel, ...]:
    """``CHANNELS`` in the units of a bench: ramps against the rate of its load train, releases against the quarter
    period of its free tip, for a tolerance is a share of what the bench shows."""
    cell = bench.load_cell
    scales = {
        "ramp": cell.stiffness.mean * bench.stage_speed / RAMP_RATE,
        "release": 0.5 * np.pi * np.sqrt(cell.mass.mean / cell.stiffness.mean) / QUARTER_PERIOD,
    }
    return tuple(replace(c, unit_scale=c.unit_scale * scales.get(c.block, 1.0)) for c in CHANNELS)
