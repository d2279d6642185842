"""The emulated rig behaves as the firmware does; the reader copes with each of its faults and never hangs."""

import termios
import time

import numpy as np
import pytest

from eaclutch.rig.link.emulator import EmulatedRig, turn_knobs
from eaclutch.rig.link.faults import FAULTS
from eaclutch.rig.link.protocol import BenchSetting, Command, digest
from eaclutch.rig.link.reader import LinkSettings, SerialLink
from eaclutch.rig.link.synthetic import SHORT, SyntheticBench
from eaclutch.rig.link.transfer import TransferFault, parse_transfer

COMMAND = Command(0.2e-3, 2e-3)
SETTINGS = LinkSettings(5.0, silence_margin=0.4, idle=0.1, reappear=3.0)
# what each fault may be called by the reader; value_equals_count is none
NAMES = {
    "silence": {"silence"}, "unplug": {"vanished"}, "unplug_in_motion": {"vanished"}, "early_reply": {"early_reply"},
    "chatter_first": {"no_count"}, "lost_line": {"lines_lost", "no_separator", "no_count"},
}  # fmt: skip


def rig_at(tmp_path, fault=None, seed=1, **further):
    rng = np.random.default_rng(seed)
    faults = iter([fault])
    return EmulatedRig(
        SyntheticBench(rng, SHORT), tmp_path / "rig", rng=rng, timing=SHORT, speed_factor=5,
        faults=lambda: next(faults, None), away=0.1, **further,
    )  # fmt: skip


def transfer(link):
    return parse_transfer(link.transfer(COMMAND).raw, SHORT)


def test_it_is_silent_while_it_moves_then_sends_all(tmp_path):
    with rig_at(tmp_path) as rig, SerialLink(str(tmp_path / "rig"), SHORT, SETTINGS) as link:
        reply = link.transfer(COMMAND)
    assert reply.first_byte >= 0.95 * COMMAND.silence(SHORT) / 5
    assert digest(parse_transfer(reply.raw, SHORT).columns) == rig.sent[0].sha256


@pytest.mark.parametrize("fault", FAULTS)
def test_after_any_fault_the_next_transfer_is_sound(tmp_path, fault):
    started = time.monotonic()
    with rig_at(tmp_path, fault) as rig, SerialLink(str(tmp_path / "rig*"), SHORT, SETTINGS) as link:
        try:
            got = transfer(link)
        except TransferFault as refused:
            assert fault not in NAMES or refused.code in NAMES[fault]
            assert fault != "value_equals_count"
            link.settle(COMMAND)
        else:
            assert fault not in NAMES
            assert fault == "swapped_digit" or digest(got.columns) == rig.sent[-1].sha256
        assert digest(transfer(link).columns) == rig.sent[-1].sha256
        assert len(rig.sent) == 2
    assert time.monotonic() - started < 20.0


def test_it_comes_back_under_another_name(tmp_path):
    with rig_at(tmp_path, "unplug") as rig, SerialLink(str(tmp_path / "rig*"), SHORT, SETTINGS) as link:
        with pytest.raises(TransferFault, match="vanished"):
            link.transfer(COMMAND)
        transfer(link)
        assert link.port.endswith("rig-1")
        assert rig.port.name == "rig-1"


def test_a_port_that_is_pulled_while_the_command_goes_out(tmp_path, monkeypatch):
    def pulled(self):
        raise termios.error(5, "Input/output error")

    with rig_at(tmp_path), SerialLink(str(tmp_path / "rig"), SHORT, SETTINGS) as link:
        with monkeypatch.context() as patch, pytest.raises(TransferFault, match="vanished"):
            patch.setattr("serial.Serial.flush", pulled)
            link.transfer(COMMAND)
        link.settle(COMMAND)
        transfer(link)


def test_a_limited_link_takes_its_time(tmp_path):
    with (
        rig_at(tmp_path, bytes_per_s=200_000) as rig,
        SerialLink(str(tmp_path / "rig"), SHORT, SETTINGS) as link,
    ):
        reply = link.transfer(COMMAND)
    assert digest(parse_transfer(reply.raw, SHORT).columns) == rig.sent[0].sha256
    assert reply.last_byte - reply.first_byte > 0.8 * len(reply.raw) / 200_000


def test_what_the_rig_says_of_itself_when_its_source_fails(tmp_path):
    def broken(setting, command):
        raise ValueError("no bench")

    rig = EmulatedRig(broken, tmp_path / "rig", rng=np.random.default_rng(1), timing=SHORT)
    with pytest.raises(ValueError, match="no bench"), rig:
        with SerialLink(str(tmp_path / "rig"), SHORT, SETTINGS) as link, pytest.raises(TransferFault):
            link.transfer(COMMAND)
        assert rig.ended.is_set()


def test_switched_off_it_leaves_nothing_behind(tmp_path):
    with rig_at(tmp_path):
        turn_knobs(tmp_path / "rig", BenchSetting(300.0, 1000.0, 2e-3, "brass"))
    assert list(tmp_path.iterdir()) == []
