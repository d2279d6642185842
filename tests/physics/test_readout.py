"""A low pass behind the load cell, against scipy's filter of the unfiltered reading."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel

TIMES = ("release_time_10_s", "release_time_50_s", "release_time_90_s")
LAG = 3e-4


def filtered(force, step):
    keep = np.exp(-step / LAG)
    return lfilter([1 - keep], [1, -keep], force, zi=[keep * force[0]])[0]


def test_the_logged_release_is_that_of_the_filtered_reading(runs, bench):
    conditions = runs(voltage=250.0, frequency=10.0, switch_off_force=0.9, friction_before=0.1)
    off = float(conditions.drive_duration[0])
    step = 1e-6
    time = off + np.arange(1e-9, 0.03, step)
    plain = ClutchModel(bench)
    force = plain.history(conditions, 0, {}, time)
    final = plain.predict(conditions, {}, ("final_force_n",)).values["final_force_n"][0, 0]
    read = filtered(force, step)
    levels = 0.9 - np.array([0.1, 0.5, 0.9]) * (0.9 - final)
    expected = [time[np.argmax(read <= level)] - off for level in levels]
    lagging = ClutchModel(bench, (*BASE, "readout_lag")).predict(
        conditions, {"readout_lag.time_constant": LAG}, TIMES
    )
    found = [lagging.values[name][0, 0] for name in TIMES]
    assert found == pytest.approx(expected, abs=2e-6)
    late = np.array(found) - [plain.predict(conditions, {}, TIMES).values[name][0, 0] for name in TIMES]
    assert np.all(np.diff(late) > 0) and 0.2 * LAG < late[0] < late[1] < 1.05 * LAG


def test_a_history_is_read_through_the_low_pass(runs, bench):
    conditions = runs(voltage=250.0, frequency=10.0, switch_off_force=0.9, friction_before=0.1)
    time = float(conditions.drive_duration[0]) + np.arange(-1e-3, 0.01, 2e-6)
    force = ClutchModel(bench).history(conditions, 0, {}, time)
    read = ClutchModel(bench, (*BASE, "readout_lag")).history(
        conditions, 0, {"readout_lag.time_constant": LAG}, time
    )
    np.testing.assert_allclose(read, filtered(force, 2e-6), atol=5e-3)
    assert np.max(np.abs(read - force)) > 0.1


def test_a_zero_that_moves_shifts_what_is_read_and_not_what_is_timed(runs, bench):
    """0.03 N/s over 3 s: readings after the drive are 0.09 N too high; the release is that of the true force."""
    plain, drifting = ClutchModel(bench), ClutchModel(bench, (*BASE, "reading_drift"))
    rate = {"reading_drift.rate": 0.03, "reading_drift.voltage_exponent": 1.0}
    true = runs(voltage=300.0, frequency=10.0, switch_off_force=0.9, friction_before=0.1)
    shift = 0.03 * float(true.drive_duration[0])
    read = runs(voltage=300.0, frequency=10.0, switch_off_force=0.9 + shift, friction_before=0.1)
    expected, found = plain.predict(true).values, drifting.predict(read, rate).values
    for name in (*TIMES, "slip_fraction", "friction_before_n"):
        assert found[name] == pytest.approx(expected[name], rel=1e-9)
    for name in ("final_force_n", "baseline_shift_n", "switch_off_force_n"):
        assert found[name] == pytest.approx(expected[name] + shift, rel=1e-9)
    assert found["shear_capacity_n"] == pytest.approx(expected["shear_capacity_n"] + shift * 2 / 3, rel=1e-9)
    assert found["hold_creep_n_s"] == pytest.approx(0.03)
    assert found["ramp_rate_n_s"] == pytest.approx(expected["ramp_rate_n_s"] + 0.03)
    time = np.array([-0.1, 1.0, float(true.drive_duration[0]) + 0.05])
    moved = drifting.history(read, 0, rate, time) - plain.history(true, 0, {}, time)
    assert moved == pytest.approx([0.0, 0.03, shift], abs=1e-9)
