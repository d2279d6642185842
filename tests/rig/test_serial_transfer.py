"""The reader's promise: what it accepts is what was sent; everything else has a name."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eaclutch.records import InputError
from eaclutch.rig.link.faults import CORRUPTIONS, corrupt
from eaclutch.rig.link.protocol import BenchSetting, Columns, Command, Timing, digest, on_the_grid, render
from eaclutch.rig.link.setting_check import check_setting
from eaclutch.rig.link.synthetic import SHORT, SyntheticBench
from eaclutch.rig.link.transfer import Grid, TransferFault, parse_transfer
from eaclutch.rig.logs import read_log

SETTING = BenchSetting(300.0, 1000.0, 2e-3, "brass")
COMMAND = Command(0.2e-3, 2e-3)


def columns(seed: int, timing: Timing = SHORT, command: Command = COMMAND) -> Columns:
    recording = SyntheticBench(np.random.default_rng(seed), timing)(SETTING, command)
    return on_the_grid(Columns(recording.time * 1e6, recording.force, recording.flag, recording.voltage))


def test_command_bytes_are_the_rigs():
    assert Command(1.5e-3, 0.5e-3).encode() == b"\x0f\x0a"
    back = Command.decode(b"\x0f\x0a")
    assert (back.travel, back.speed) == pytest.approx((1.5e-3, 0.5e-3))
    assert Command(1.5e-3, 0.5e-3).recording_duration(Timing()) == pytest.approx(7.0)
    assert Command(1.5e-3, 0.5e-3).silence(Timing()) == pytest.approx(12.0)


@pytest.mark.parametrize(
    "travel, speed", [(0.0, 0.5e-3), (1.55e-3, 0.5e-3), (30e-3, 0.5e-3), (1e-3, 0.51e-3)]
)
def test_what_two_bytes_cannot_say_is_refused(travel, speed):
    with pytest.raises(InputError, match="cannot be told"):
        Command(travel, speed).encode()


def test_an_undisturbed_reply_comes_back_bit_by_bit():
    sent = columns(1)
    got = parse_transfer(render(sent), SHORT)
    assert digest(got.columns) == digest(sent)
    assert got.repairs == ()
    for name in ("time_us", "force", "flag", "voltage"):
        np.testing.assert_array_equal(getattr(got.columns, name), getattr(sent, name))


def test_a_value_that_equals_the_count_is_a_value():
    sent = columns(2)
    time_us = sent.time_us + (len(sent) - sent.time_us[15])
    sent = Columns(time_us, sent.force, sent.flag, sent.voltage)
    assert len(sent) in sent.time_us
    assert digest(parse_transfer(render(sent), SHORT).columns) == digest(sent)


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(sorted(set(CORRUPTIONS) - {"swapped_digit"})), st.integers(0, 2**32 - 1))
def test_a_disturbed_reply_is_refused_or_repaired_exactly(fault, seed):
    sent = columns(3)
    raw = corrupt(render(sent), fault, np.random.default_rng(seed))
    try:
        got = parse_transfer(raw, SHORT)
    except TransferFault as refused:
        assert refused.code
        return
    assert digest(got.columns) == digest(sent)
    assert got.repairs


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=400))
def test_any_bytes_have_a_named_fault(raw):
    with pytest.raises(TransferFault):
        parse_transfer(raw, SHORT)


def test_a_lost_sign_or_digit_leaves_the_converters_grid():
    sent = columns(4)
    lines = render(sent).split(b"\r\n")
    first_force = len(sent) + 2
    row = next(i for i in range(first_force, first_force + len(sent)) if lines[i].startswith(b"-"))
    lines[row] = lines[row][1:]
    with pytest.raises(TransferFault, match="force_off_grid"):
        parse_transfer(b"\r\n".join(lines), SHORT)
    assert parse_transfer(b"\r\n".join(lines), SHORT, Grid(None, None)).checks["force_grid_residual"] is None


def test_lost_line_endings_and_merged_lines_are_mended_and_said():
    sent = columns(5)
    raw = render(sent)
    middle = raw.index(b"\r\n", len(raw) // 2 - len(raw) // 8)
    for damaged, word in (
        (raw[:middle] + raw[middle + 1 :], "line_ending"),
        (raw[: middle + 1] + raw[middle + 2 :], "line_ending"),
        (raw[:middle] + raw[middle + 2 :], "merged_lines"),
    ):
        got = parse_transfer(damaged, SHORT)
        assert got.repairs == (word,)
        assert digest(got.columns) == digest(sent)


def test_a_whole_run_takes_under_a_second_of_cpu():
    raw = render(columns(6, Timing(), Command(1.5e-3, 0.5e-3)))
    started = time.process_time()
    got = parse_transfer(raw, Timing())
    assert len(got.columns) > 89_000
    assert time.process_time() - started < 1.0


def test_a_bench_that_is_not_as_planned_is_told():
    sent = columns(7)
    found = check_setting(sent, SETTING, 0.15)
    assert found["sensed_voltage_v"] == pytest.approx(300.0, abs=1.0)
    assert found["sensed_frequency_hz"] == pytest.approx(1000.0, rel=0.03)
    with pytest.raises(TransferFault, match="wrong_voltage"):
        check_setting(sent, BenchSetting(200.0, 1000.0, 2e-3, "brass"), 0.15)
    with pytest.raises(TransferFault, match="wrong_frequency"):
        check_setting(sent, BenchSetting(300.0, 100.0, 2e-3, "brass"), 0.15)
    with pytest.raises(TransferFault, match="wrong_frequency"):
        check_setting(sent, BenchSetting(300.0, 0.1, 2e-3, "brass"), 0.15)
    dead = Columns(sent.time_us, sent.force, sent.flag, 0 * sent.voltage)
    with pytest.raises(TransferFault, match="no voltage"):
        check_setting(dead, SETTING, 0.15)


@pytest.mark.published
def test_published_logs_are_accepted_unless_a_column_slid(published):
    """The same checks on what the rig really recorded: whole columns pass, those with a zero tail do not."""
    verdicts = {}
    for path in sorted((published / "tensile").iterdir())[::12]:
        recording = read_log(path)
        sent = Columns(recording.time * 1e6, recording.force, recording.flag, recording.voltage)
        slid = not (recording.force[-20:].any() and recording.voltage[-20:].any() and recording.time[-1])
        try:
            check_setting(
                sent, BenchSetting(recording.settings.voltage, recording.settings.frequency, 0, ""), 0.15
            )
            accepted = digest(parse_transfer(render(sent), Timing()).columns) == digest(sent)
        except TransferFault:
            accepted = False
        verdicts[path.name] = accepted, slid
    assert [name for name, (accepted, slid) in verdicts.items() if accepted == slid] == []
    assert {accepted for accepted, _ in verdicts.values()} == {True, False}
