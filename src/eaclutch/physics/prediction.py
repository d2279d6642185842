"""What a prediction is: values of observables and a named status for each simulated part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from eaclutch.records import FloatArray


class Status(IntEnum):
    """How a simulated part ended.

    pull_in: no equilibrium gap with voltage; never_slips: the tip never moves (release), or the drive ends before
    the static capacity is reached (capacity: the value is then the force reached); timed_out: not done within the
    simulated 0.11 s (or no voltage to engage); invalid: parameters outside their bounds, not simulated.
    """

    ok = 0
    pull_in = 1
    never_slips = 2
    timed_out = 3
    invalid = 4


# Which simulated part an observable rests on; its value is finite where that part's status is ok.
PART = {
    "friction_before_n": "capacity",
    "engagement_time_s": "engagement",
    "ramp_rate_n_s": "capacity",
    "ramp_rate_early_n_s": "capacity",
    "ramp_rate_late_n_s": "capacity",
    "shear_capacity_n": "capacity",
    "switch_off_force_n": "capacity",
    "slip_fraction": "capacity",
    "hold_creep_n_s": "capacity",
    "start_ratio": "release",
    "release_time_10_s": "release",
    "release_time_50_s": "release",
    "release_time_90_s": "release",
    "ringdown_frequency_hz": "ringdown",
    "ringdown_damping_ratio": "ringdown",
    "final_force_n": "release",
    "baseline_shift_n": "release",
}
OBSERVABLES = tuple(PART)


@dataclass(frozen=True)
class Prediction:
    """values: {observable: (draws, runs)} in SI; status: {part: int8 (draws, runs)} of ``Status``;
    state: {"preload", "gap_before", "gap_driven"}: (draws, runs) [N, m, m]."""

    values: Mapping[str, FloatArray]
    status: Mapping[str, NDArray[np.int8]]
    state: Mapping[str, FloatArray]

    def status_of(self, observable: str) -> NDArray[np.int8]:
        """Status (draws, runs) of the part that ``observable`` rests on."""
        return self.status[PART[observable]]
