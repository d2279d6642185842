"""The contract's observables from what the solver returns."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from eaclutch.records import FloatArray

AT_LARGEST = 2 / 3  # of the drive, where the largest of many slips is


def observable(name: str, result: Mapping[str, FloatArray], table: NDArray[np.void]) -> FloatArray:
    """Observable ``name`` (draws, runs) from the solver's ``result`` columns and its rows ``table``."""
    before = table["friction_before"]
    drift = table["reading_drift"]
    off = drift * table["drive_duration"]  # by which the reading is, from switch-off on
    largest = result["capacity"] + AT_LARGEST * off
    alive = np.where(np.isnan(result["capacity"]), np.nan, 1.0)
    if name == "friction_before_n":
        return before * alive
    if name == "shear_capacity_n":
        return largest - before
    if name == "switch_off_force_n":
        return result["own_switch_off"] + off  # also where the release starts from a measured one
    if name == "start_ratio":
        span = largest - result["final"] - off
        ratio = (result["switch_off"] - result["final"]) / np.where(span == 0.0, np.nan, span)
        return np.where(span == 0.0, 0.0, ratio)  # nothing is held above the rest level
    if name == "slip_fraction":
        return result["slip_fraction"].copy()
    if name == "hold_creep_n_s":
        return drift * alive  # the tip sticks while the stage rests
    if name == "final_force_n":
        return result["final"] + off
    if name == "baseline_shift_n":
        return result["final"] + off - before
    if name.startswith("ringdown"):
        free = np.where((table["load_cell_dynamic"] != 0) & (alive == 1.0), 1.0, np.nan)
        beta = 0.5 * table["load_cell_damping"] / table["mass"]
        omega = np.sqrt(table["stiffness"] / table["mass"])
        if name == "ringdown_damping_ratio":
            return free * beta / omega
        return free * np.sqrt(np.maximum(omega**2 - beta**2, 0.0)) / (2 * np.pi)
    column = {
        "engagement_time_s": "engagement",
        "ramp_rate_n_s": "ramp",
        "ramp_rate_early_n_s": "ramp_early",
        "ramp_rate_late_n_s": "ramp_late",
        "release_time_10_s": "release_10",
        "release_time_50_s": "release_50",
        "release_time_90_s": "release_90",
    }[name]
    return result[column] + (drift if name.startswith("ramp") else 0.0)
