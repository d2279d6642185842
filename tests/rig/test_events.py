"""Voltage on and off in awkward logs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eaclutch.records import Bench
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.events import find_events
from eaclutch.rig.extract import extract
from eaclutch.rig.hidden_wave import habit
from eaclutch.rig.repair import make_whole
from rig.made_run import STEP, grounded_since, made, on_of, without_lines


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


@pytest.mark.parametrize(("delay", "known"), [(0.1e-3, True), (0.6e-3, False)])
def test_a_wave_that_may_have_begun_unseen_leaves_open_when_a_force_that_holds_was_released(delay, known):
    """The flag falls with a half wave's end, the voltage has lost lines: a film that is slow to open looks as if the
    drive had begun another half wave."""
    recording, _, off = made(frequency=1000.0, delay=delay)
    broken = replace(recording, voltage=without_lines(recording.voltage, (60_000, 300)))
    whole = make_whole(broken).recording
    events = find_events(whole)
    assert ("voltage_off_unsure" not in events.flags) is known
    assert np.isnan(extract(broken, Bench("test"))["release_time_50_s"]) != known
    stops = find_events(whole, finishes=False)  # other runs: this drive stops with its flag
    assert abs(stops.off - off) <= 1.1 * STEP and "voltage_off_unsure" not in stops.flags


@pytest.mark.parametrize("finishes", [False, True])
def test_what_other_runs_say_of_the_drive_counts_where_a_force_has_hardly_time_to_tell(finishes):
    """Flag and force alike, 0.2 ms before the grounded half wave would end: other runs know where off was."""
    recording, _, off = made(delay=0.3e-3)
    events = find_events(grounded_since(recording, on_of(recording), 1000.0, 0.3e-3), finishes=finishes)
    assert events.left_open and events.finishes is None and events.off_sd < 0.5 * STEP
    assert abs(events.off - off - (0.2e-3 if finishes else 0.0)) <= 1.1 * STEP
    assert ("voltage_outlives_flag" in events.flags) is finishes and "voltage_off_unsure" not in events.flags


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
