"""What is put right in broken columns, and what is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eaclutch.records import Bench
from eaclutch.rig.columns_in_step import lost_lines
from eaclutch.rig.extract import extract, extract_view
from eaclutch.rig.repair import make_whole
from rig.made_run import STEP, Made, grounded_since, made, make_run, on_of, release_time, without_lines


def test_a_column_that_is_zero_at_rest_has_lost_nothing():
    recording, *_ = made()
    resting = np.where(recording.voltage > 50, 300.0, 0.0)
    assert lost_lines(resting) == 0
    assert lost_lines(without_lines(recording.force, (20_000, 77))) == 77


def test_a_coarse_force_that_passes_through_zero_has_lost_its_lines_none_the_less():
    """Counts of 2 mN and an offset near zero: some percent of the samples read exactly zero, as the tail does."""
    recording, *_ = made(friction=0.0, final=0.0)
    coarse = 0.002 * np.round(recording.force / 0.002)
    assert np.mean(coarse == 0) > 0.02 and lost_lines(coarse) == 0
    found = extract(replace(recording, force=without_lines(coarse, (20_000, 1977))), Bench("test"))
    assert {"force_lines_lost", "force_realigned"} <= set(found["flags"].split(";"))
    wanted = release_time(Made(friction=0.0, final=0.0), 0.5)
    assert found["release_time_50_s"] == pytest.approx(wanted, abs=4 * found["release_time_50_s_sd"])
    coarser = 0.02 * np.round(recording.force / 0.02)
    # how many of its last zeros are its own is not known any more
    assert lost_lines(without_lines(coarser, (20_000, 77))) == 0


@pytest.mark.parametrize("holes", [((16_000, 14),), ((5_000, 60), (70_000, 200))])
def test_time_with_holes_and_a_tail_of_zeros_is_put_back(holes):
    recording, *_ = made()
    broken = replace(recording, time=without_lines(recording.time, *holes))
    whole = make_whole(broken).recording
    assert whole.flags == ("time_realigned",)
    assert np.max(np.abs(whole.time - recording.time)) < 2e-6


def test_single_samples_are_mended_and_said():
    recording, *_ = made()
    force, time = recording.force.copy(), recording.time.copy()
    force[40_000] -= 1.0
    force[50_000] = np.nan
    time[60_000] = 0.1
    whole = make_whole(replace(recording, force=force, time=time)).recording
    assert set(whole.flags) == {"force_glitch", "force_missing", "time_repaired"}
    assert abs(whole.force[40_000] - recording.force[40_000]) < 0.06
    assert abs(whole.time[60_000] - recording.time[60_000]) < 2e-6
    untouched = np.ones(len(force), dtype=bool)
    untouched[[40_000, 50_000]] = False
    assert np.array_equal(whole.force[untouched], recording.force[untouched])


def test_time_that_runs_backwards_for_long_is_not_used():
    recording, *_ = made()
    time = recording.time.copy()
    time[45_000:45_400] = time[45_000:45_400][::-1]
    found = extract(replace(recording, time=time), Bench("test"))
    assert "time_broken" in found["flags"] and not found["usable"]


@pytest.mark.parametrize("ends", [4, 11, 24, 700])
def test_a_hole_that_swallows_the_release_leaves_no_release_time(ends):
    recording, _, off = made(frequency=0.1, capacity=0.5, hold=0.47)
    last = round(off / STEP) + ends
    found = extract(
        replace(recording, force=without_lines(recording.force, (last - 720, 720))), Bench("test")
    )
    assert np.isnan(found["release_time_50_s"]) and "force_not_in_step" in found["flags"]


@given(
    start=st.integers(3_000, 88_000), count=st.integers(8, 9_000) | st.integers(8, 60), seed=st.integers(0, 3)
)
@settings(max_examples=25, deadline=None)
def test_wherever_lines_were_lost_the_release_is_right_or_missing(start, count, seed):
    shape = Made(frequency=0.1, capacity=0.5, hold=0.47)
    recording, *_ = make_run(shape, np.random.default_rng(seed))
    start = min(start, len(recording.time) - count - 1)
    found = extract(replace(recording, force=without_lines(recording.force, (start, count))), Bench("test"))
    assert "force_lines_lost" in found["flags"]
    for share in (0.1, 0.5, 0.9):
        value, sd = (found[f"release_time_{share * 100:g}_s{end}"] for end in ("", "_sd"))
        if np.isfinite(value):
            assert abs(value - release_time(shape, share)) < 5 * sd


def test_a_dead_load_cell_and_another_rate_are_said():
    recording, *_ = made()
    dead = extract(replace(recording, force=np.full_like(recording.force, 0.013)), Bench("test"))
    assert "force_stuck" in dead["flags"] and not dead["usable"] and np.isnan(dead["friction_before_n"])
    columns = {name: getattr(recording, name)[::2] for name in ("time", "force", "flag", "voltage")}
    slow = extract(replace(recording, **columns), Bench("test"))
    assert "other_sample_rate" in slow["flags"]
    assert slow["friction_before_n"] == pytest.approx(0.12, abs=5 * slow["friction_before_n_sd"])
    assert slow["release_time_50_s"] == pytest.approx(
        release_time(Made(), 0.5), abs=5 * slow["release_time_50_s_sd"]
    )


@pytest.mark.parametrize("time", [np.zeros(2000), np.full(2000, np.nan), np.tile([3.0, 1.0, 2.0, 0.0], 500)])
def test_a_clock_that_stands_or_jumps_measures_nothing(time):
    recording, *_ = made()
    columns = {name: getattr(recording, name)[24_600:26_600] for name in ("force", "flag", "voltage")}
    columns["force"] = without_lines(columns["force"], (500, 100))
    found = extract(replace(recording, time=time, **columns), Bench("test"))
    assert "time_broken" in found["flags"] and not found["usable"]


@pytest.mark.parametrize("finished", [False, True])
def test_lost_lines_as_many_as_an_unseen_wave_has_leave_open_when_the_force_fell(finished):
    """It stands 0.2 ms behind the flag: lines lost behind the release of a drive that stopped with its flag, or lost
    while driven by one that finished its half wave. What was measured of the hold is known all the same."""
    shape = Made(frequency=50.0, delay=0.3e-3)
    recording, _, off = make_run(shape, np.random.default_rng(3))
    broken = lost_within_a_wave(recording, off, finished, 40_000 if finished else 80_000)
    row = extract(broken, Bench("test"))
    assert np.isnan(row["release_time_50_s"]) and "force_not_in_step" in row["flags"].split(";")
    assert row["shear_capacity_n"] == pytest.approx(0.6, abs=0.03)
    _, known = extract_view(broken, Bench("test"), finished)
    assert known["release_time_50_s"] == pytest.approx(
        release_time(shape, 0.5), abs=5 * known["release_time_50_s_sd"]
    )


@pytest.mark.parametrize("habit", [None, False, True])
def test_lines_lost_before_the_voltage_are_missing_at_its_release_whatever_the_drives_habit(habit):
    shape = Made(frequency=50.0, delay=0.3e-3)
    recording, _, off = make_run(shape, np.random.default_rng(3))
    _, row = extract_view(lost_within_a_wave(recording, off, True, 16_000), Bench("test"), habit)
    assert "force_realigned" in row["flags"].split(";")
    assert row["release_time_50_s"] == pytest.approx(
        release_time(shape, 0.5), abs=5 * row["release_time_50_s_sd"]
    )


def lost_within_a_wave(recording, off, finished, place):
    """105 lines (8.2 ms) of the force lost at ``place``, as many as lie between the flag's fall and the wave's end."""
    recording = grounded_since(recording, on_of(recording), 50.0, 10e-3 if finished else 1.8e-3)
    return replace(
        recording,
        flag=recording.flag * (recording.time < off - (8.2e-3 if finished else 0.0)),
        force=without_lines(recording.force, (place, 105)),
        voltage=without_lines(recording.voltage, (85_000, 226)),
    )
