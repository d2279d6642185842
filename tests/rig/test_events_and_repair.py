"""Voltage on and off in awkward logs, and what is put right in broken columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eaclutch.records import Bench
from eaclutch.rig.columns_in_step import lost_lines
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.events import find_events
from eaclutch.rig.extract import extract, extract_view
from eaclutch.rig.hidden_wave import habit
from eaclutch.rig.repair import make_whole
from rig.made_run import STEP, Made, make_run, release_time, without_lines


def made(seed: int = 0, **changes):
    return make_run(Made(**changes), np.random.default_rng(seed))


@pytest.mark.parametrize("frequency", [0.1, 1.0, 10.0, 1000.0, 10000.0])
@pytest.mark.parametrize("grounded_first", [False, True])
def test_on_and_off_are_found_within_half_a_sample(frequency, grounded_first):
    recording, on, off = made(frequency=frequency, grounded_first=grounded_first)
    events = find_events(recording)
    assert abs(events.on - on) <= 0.51 * STEP and abs(events.off - off) <= 0.51 * STEP
    assert events.on_sd == pytest.approx(STEP / np.sqrt(12), rel=0.02)
    assert events.dwell == pytest.approx(off - on - 3.0, abs=STEP)


@pytest.mark.parametrize("grounded_first", [False, True])
def test_the_driver_finishes_its_half_wave_after_the_flag(grounded_first):
    recording, on, off = made(frequency=7.0, grounded_first=grounded_first)
    early = replace(recording, flag=((recording.time >= on) & (recording.time < off - 0.05)).astype(float))
    events = find_events(early)
    assert events.off == pytest.approx(off, abs=1.6 * STEP)
    assert "voltage_outlives_flag" in events.flags


def grounded_since(recording, on, frequency, seconds):
    """The recording with polarity edges so that the sensed electrode is grounded ``seconds`` before voltage off."""
    half = 0.5 / frequency
    driven = recording.flag > 0.5
    waves = np.floor((recording.time - on + seconds) / half).astype(int)
    return replace(recording, voltage=np.where(driven & (waves % 2 == 1), 300.0, 2.0))


@pytest.mark.parametrize(
    ("frequency", "seconds"), [(1000.0, 0.1e-3), (1000.0, 0.2e-3), (10.0, 0.03), (1.0, 0.2)]
)
def test_a_drive_that_stops_within_its_half_wave_is_told_from_one_that_finishes_it(frequency, seconds):
    recording, on, off = made(frequency=frequency, delay=0.1e-3)
    events = find_events(grounded_since(recording, on, frequency, seconds))
    assert abs(events.off - off) <= 0.51 * STEP and "voltage_outlives_flag" not in events.flags
    finished = replace(recording, flag=(recording.time >= on) & (recording.time < off - 0.34 / frequency))
    events = find_events(
        replace(finished, voltage=np.where(recording.time < off - 0.5 / frequency, recording.voltage, 2.0))
    )
    assert abs(events.off - off) <= 1.6 * STEP and "voltage_outlives_flag" in events.flags


def test_where_the_force_cannot_tell_when_the_drive_stopped_the_instant_is_uncertain():
    recording, on, off = made(delay=0.3e-3)
    events = find_events(grounded_since(recording, on, 1000.0, 0.3e-3))
    assert "voltage_off_unsure" in events.flags
    assert abs(events.off - off) < np.sqrt(3) * events.off_sd + STEP and events.off_sd > 0.05e-3


@pytest.mark.parametrize(("frequency", "surely"), [(0.5, True), (10.0, True), (50.0, True), (500.0, False)])
@pytest.mark.parametrize("after_the_edge", [0.3 * STEP, 1.2 * STEP])
def test_a_flag_that_falls_as_another_wave_begins_is_not_off(frequency, surely, after_the_edge):
    """The sensed wave ends with the flag, and the other electrode's goes on: only the force shows it."""
    half = 0.5 / frequency
    waves = round(3.0 / half) // 2 * 2 + 1
    recording, _, off = made(frequency=frequency, travel=waves * half * 0.5e-3, grounded_first=True, seed=2)
    fallen = replace(recording, flag=(recording.time < off - half + after_the_edge) & (recording.flag > 0.5))
    events = find_events(fallen)
    if surely:
        assert abs(events.off - off) <= 1.6 * STEP and "voltage_outlives_flag" in events.flags
    else:
        assert abs(events.off - off) < np.sqrt(3) * events.off_sd + 2 * STEP
        assert "voltage_off_unsure" in events.flags


@pytest.mark.parametrize("swing", [0.2, 0.5])
def test_a_force_that_swings_back_as_the_next_wave_would_end_was_released(swing):
    """Three quarters of a free swing after its release the force stands where it was held."""
    half = 2.17e-3
    waves = round(3.0 / half) // 2 * 2
    recording, _, off = made(
        frequency=0.5 / half, travel=waves * half * 0.5e-3, grounded_first=True, swing=swing
    )
    events = find_events(recording)
    assert abs(events.off - off) <= 0.51 * STEP
    assert "voltage_off_unsure" not in events.flags and "voltage_outlives_flag" not in events.flags


def test_a_release_is_no_creep_and_has_no_time_where_its_instant_is_not_known():
    """A film that is slow to open, or another half wave: off lies anywhere within 1.7 ms."""
    half = 0.5 / 300.0
    waves = round(3.0 / half) // 2 * 2
    recording, _, _ = made(
        frequency=300.0, travel=waves * half * 0.5e-3, grounded_first=True, delay=0.6e-3, fall=2.2e-3
    )
    stopped = replace(recording, settings=replace(recording.settings, travel=1.0e-3))
    row = extract(stopped, Bench("test"))
    assert "voltage_off_unsure" in row["flags"]
    assert row["switch_off_force_n"] == pytest.approx(0.67, abs=5 * row["switch_off_force_n_sd"] + 0.002)
    assert abs(row["hold_creep_n_s"]) < 5 * row["hold_creep_n_s_sd"] + 1e-3
    assert np.isnan(row["release_time_50_s"]) and "release_time_50_s:off_unsure" in row["reasons"]


def test_what_rests_on_an_instant_that_is_not_known_is_not_said():
    """A flag that lost lines at 50 Hz: off is known to half a period, the force there is not, and the end is."""
    recording, _, _ = made(frequency=50.0, final=0.06)
    row = extract(
        replace(recording, flag=without_lines(recording.flag, (int(3.5 / STEP), 300))), Bench("test")
    )
    assert row["flags"].split(";").count("flag_early") == 1
    assert np.isnan(row["switch_off_force_n"]) and "switch_off_force_n:off_unsure" in row["reasons"]
    assert row["baseline_shift_n"] == pytest.approx(-0.06, abs=5 * row["baseline_shift_n_sd"])


def test_a_slow_release_makes_no_wave_that_is_not_seen():
    recording, _, off = made(frequency=100.0, delay=8e-3, grounded_first=True)
    assert abs(find_events(recording).off - off) <= 0.51 * STEP


@pytest.mark.parametrize("frequency", [0.1, 1000.0])
@pytest.mark.parametrize("hole", ["before", "driven"])
def test_a_flag_that_lost_lines_gives_way_to_the_voltage(frequency, hole):
    recording, on, off = made(frequency=frequency)
    start = int((1.0 if hole == "before" else 3.5) / STEP)
    events = find_events(replace(recording, flag=without_lines(recording.flag, (start, 300))))
    assert abs(events.on - on) < 0.6 * STEP + 2 * events.on_sd
    assert abs(events.off - off) < 0.6 * STEP + 2 * events.off_sd
    assert {"flag_early", "voltage_outlives_flag"} & set(events.flags)


def test_stray_samples_are_no_events():
    recording, on, off = made()
    flag, voltage = recording.flag.copy(), recording.voltage.copy()
    flag[5_000], flag[80_000], flag[40_000], voltage[75_000] = 1.0, 1.0, 0.0, 300.0
    events = find_events(replace(recording, flag=flag, voltage=voltage))
    assert abs(events.on - on) < 0.51 * STEP and abs(events.off - off) < 0.51 * STEP


def test_what_has_no_voltage_or_no_end_is_said():
    recording, *_ = made()
    for change, reason in (
        ({"voltage": np.full_like(recording.voltage, 2.0)}, "no_voltage"),
        ({"flag": np.zeros_like(recording.flag)}, "no_flag"),
        ({"flag": np.maximum.accumulate(recording.flag)}, "flag_never_falls"),
    ):
        with pytest.raises(Unusable, match=reason):
            find_events(replace(recording, **change))


def test_voltage_that_lost_lines_does_not_move_the_events():
    recording, on, off = made(frequency=10.0)
    broken = replace(recording, voltage=without_lines(recording.voltage, (30_000, 400)))
    whole = make_whole(broken).recording
    events = find_events(whole)
    assert "voltage_lines_lost" in whole.flags
    assert abs(events.on - on) < STEP and abs(events.off - off) < STEP


@pytest.mark.parametrize("grounded_first", [False, True])
@pytest.mark.parametrize("hole", [41_000, 60_000])
def test_where_the_voltage_lost_lines_the_wave_that_outlives_the_flag_is_reckoned(grounded_first, hole):
    """With a voltage that has lost lines before the end nothing is seen there; the waves before say when one ends."""
    recording, on, off = made(frequency=7.0, grounded_first=grounded_first)
    flag = ((recording.time >= on) & (recording.time < off - 0.05)).astype(float)
    broken = replace(recording, flag=flag, voltage=without_lines(recording.voltage, (hole, 3_000)))
    events = find_events(make_whole(broken).recording)
    assert abs(events.off - off) <= 3.0 * STEP and "voltage_outlives_flag" in events.flags


@pytest.mark.parametrize("hole", [26_000, 41_000])
def test_where_nothing_shows_when_an_unseen_drive_stopped_no_release_time_is_said(hole):
    """The force holds for 20 ms after the flag and lets go within a half wave, or where no wave can be reckoned."""
    recording, on, off = made(frequency=7.0)
    recording = grounded_since(recording, on, 7.0, 0.03)
    flag = ((recording.time >= on) & (recording.time < off - 0.02)).astype(float)
    broken = replace(recording, flag=flag, voltage=without_lines(recording.voltage, (hole, 3_000)))
    row = extract(broken, Bench("test"))
    assert {"voltage_lines_lost", "voltage_off_unsure"} <= set(row["flags"].split(";"))
    assert np.isnan(row["release_time_50_s"]) and "release_time_50_s:off_unsure" in row["reasons"]


def test_a_column_that_is_zero_at_rest_has_lost_nothing():
    recording, *_ = made()
    resting = np.where(recording.voltage > 50, 300.0, 0.0)
    assert lost_lines(resting) == 0
    assert lost_lines(without_lines(recording.force, (20_000, 77))) == 77


def test_a_coarse_force_that_passes_through_zero_has_lost_its_lines_none_the_less():
    """Counts of 2 mN and an offset near zero: a tenth of the samples at rest read exactly zero, as the tail does."""
    recording, *_ = made(friction=0.0, final=0.0)
    coarse = 0.002 * np.round(recording.force / 0.002)
    assert np.mean(coarse == 0) > 0.02 and lost_lines(coarse) == 0
    found = extract(replace(recording, force=without_lines(coarse, (20_000, 1977))), Bench("test"))
    assert {"force_lines_lost", "force_realigned"} <= set(found["flags"].split(";"))
    wanted = release_time(Made(friction=0.0, final=0.0), 0.5)
    assert found["release_time_50_s"] == pytest.approx(wanted, abs=4 * found["release_time_50_s_sd"])
    coarser = 0.02 * np.round(recording.force / 0.02)
    assert (
        lost_lines(without_lines(coarser, (20_000, 77))) == 0
    )  # how many of the zeros are its own is not known


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


@pytest.mark.parametrize("finishes", [False, True])
def test_what_other_runs_say_of_the_drive_counts_where_a_force_has_hardly_time_to_tell(finishes):
    """Flag and force alike, 0.2 ms before the grounded half wave would end: other runs know where off was."""
    recording, _, off = made(delay=0.3e-3)
    events = find_events(grounded_since(recording, on_of(recording), 1000.0, 0.3e-3), finishes=finishes)
    assert events.left_open and events.finishes is None and events.off_sd < 0.5 * STEP
    assert abs(events.off - off - (0.2e-3 if finishes else 0.0)) <= 1.1 * STEP
    assert ("voltage_outlives_flag" in events.flags) is finishes and "voltage_off_unsure" not in events.flags


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
    assert "force_in_step_until_release" not in row["flags"].split(";")
    if habit is not False:
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


def on_of(recording):
    """When the flag rises [s]."""
    return float(recording.time[recording.flag > 0.5][0]) - 0.5 * STEP


def test_the_sensed_electrode_shows_whether_the_drive_finishes_its_half_waves():
    """One that stops within its wave, one that outlives the flag, and one whose wave ends with it and says neither."""
    whole, on, off = made(frequency=100.0)
    cut = replace(whole, flag=whole.flag * (whole.time < off - 2e-3))
    stopped = replace(cut, voltage=np.where(whole.time < off - 2e-3, sensed_last(whole, on), 2.0))
    outlived = replace(cut, voltage=sensed_last(whole, on))
    plain = replace(whole, voltage=sensed_last(whole, on))
    assert [find_events(run).finishes for run in (stopped, outlived, plain)] == [False, True, None]
    assert not find_events(plain).left_open  # and other runs would not say more


def sensed_last(recording, on):
    """100 Hz on the sensed electrode, which carries the last of the half waves, (samples,)."""
    waves = np.floor((recording.time - on) / 5e-3 + 1e-6)
    last = waves[recording.flag > 0.5].max()
    driven = recording.flag > 0.5
    return np.where(driven & ((last - waves) % 2 == 0), 300.0, 2.0)


def test_a_drive_has_one_habit():
    assert habit([None, True, True, True, None]) is True and habit([False] * 3) is False
    assert habit([True, None]) is None  # too few
    assert habit([True, False, True, False]) is None and habit([True] * 9 + [False]) is True
