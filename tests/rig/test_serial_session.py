"""Capture sessions against the emulated rig: nothing is lost, nothing half, nothing replaced."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from eaclutch.records import InputError
from eaclutch.rig.link.emulator import EmulatedRig, turn_knobs
from eaclutch.rig.link.faults import FAULTS, random_faults
from eaclutch.rig.link.plan import make_plan
from eaclutch.rig.link.protocol import digest
from eaclutch.rig.link.reader import SerialLink
from eaclutch.rig.link.session import Unattended, run_session
from eaclutch.rig.link.store import CampaignStore, columns_of, missing_slots
from eaclutch.rig.link.synthetic import SyntheticBench
from eaclutch.rig.logs import read_log

RIG = {
    "before_s": 0.02,
    "after_s": 0.02,
    "speed_factor": 20,
    "silence_margin_s": 0.4,
    "idle_s": 0.1,
    "reappear_s": 3,
}
DOCUMENT = {
    "name": "p", "repeats": 2, "retries": 8, "travel_mm": 0.2, "speed_mm_s": 2, "log_format": ".npy", "rig": RIG,
    "factors": {"voltage_v": [200, 300], "frequency_hz": [100, 1000]},
}  # fmt: skip
PLAN = make_plan(DOCUMENT, "plan")


class Knobs:
    def __init__(self, port, wrong_first=False):
        self.port, self.changes, self.wrong_first = port, 0, wrong_first

    def change(self, before, after):
        self.changes += 1
        turn_knobs(self.port, after)

    def wrong(self, setting, fault):
        turn_knobs(self.port, setting)


class Watch:
    def __init__(self):
        self.faults, self.paths = [], []

    def started(self, slot, done, total):
        pass

    def progress(self, phase, share):
        pass

    def refused(self, slot, fault, attempt):
        self.faults.append(fault.code)

    def finished(self, recording, path, repairs):
        self.paths.append(path)


@pytest.fixture
def campaign(tmp_path):
    folder = tmp_path / "camp"
    folder.mkdir()
    (folder / "campaign.yaml").write_text("name: camp\n")
    return folder


def rig_at(tmp_path, seed=1, faults=lambda: None, **further):
    rng = np.random.default_rng(seed)
    return EmulatedRig(
        SyntheticBench(rng, PLAN.timing), tmp_path / "rig", rng=rng, timing=PLAN.timing, speed_factor=20,
        faults=faults, away=0.1, **further,
    )  # fmt: skip


def digests(campaign):
    return {path.name: digest(columns_of(read_log(path))) for path in (campaign / "tensile").iterdir()}


def session(campaign, tmp_path, operator=None, plan=PLAN, port="rig*"):
    watch = Watch()
    with CampaignStore(campaign) as store, SerialLink(str(tmp_path / port), plan.timing, plan.link) as link:
        return run_session(plan, store, link, operator or Knobs(tmp_path / "rig"), watch), watch


def test_faults_of_the_link_never_reach_the_campaign(campaign, tmp_path):
    kinds = [fault for fault in FAULTS if fault != "swapped_digit"]
    with rig_at(tmp_path, faults=random_faults(0.4, np.random.default_rng(8), kinds)) as rig:
        summary, watch = session(campaign, tmp_path)
    assert summary.failed == ()
    assert watch.faults
    got = digests(campaign)
    assert len(got) == len(PLAN.slots) == len(watch.paths)
    assert set(got.values()) <= {sent.sha256 for sent in rig.sent}
    assert len(set(got.values())) == len(got)
    for path in watch.paths:
        record = json.loads((campaign / "capture" / f"{path.stem}.json").read_text())
        assert record["reply_sha256"] == got[path.name]
        assert record["firmware_reply"] == str(record["checks"]["count"])
    assert missing_slots(PLAN, campaign) == []
    assert (
        len(list((tmp_path / "camp.capture" / "refused").glob("*.json")))
        == summary.refused
        == len(watch.faults)
    )


def test_the_setting_of_each_run_is_the_one_its_name_says(campaign, tmp_path):
    with rig_at(tmp_path) as rig:
        _, watch = session(campaign, tmp_path)
    by_digest = {sent.sha256: sent.setting for sent in rig.sent}
    for path in watch.paths:
        recording = read_log(path)
        setting = by_digest[digest(columns_of(recording))]
        assert (setting.voltage, setting.frequency) == (
            recording.settings.voltage,
            recording.settings.frequency,
        )


def test_a_bench_that_is_not_as_planned_is_refused_then_mended(campaign, tmp_path):
    class Forgetful(Knobs):
        def change(self, before, after):
            if before is None:
                super().change(before, after)

    with rig_at(tmp_path):
        summary, watch = session(campaign, tmp_path, Forgetful(tmp_path / "rig"))
    assert summary.failed == ()
    assert set(watch.faults) <= {"wrong_voltage", "wrong_frequency"}
    assert watch.faults


def test_unattended_goes_on_only_while_nothing_changes(campaign, tmp_path):
    with rig_at(tmp_path), pytest.raises(InputError, match="capture with an operator"):
        turn_knobs(tmp_path / "rig", PLAN.slots[0].setting)
        session(campaign, tmp_path, Unattended())
    assert len(digests(campaign)) == 1


def test_it_goes_on_where_it_was_stopped(campaign, tmp_path):
    class Stop(Knobs):
        def change(self, before, after):
            if self.changes == 3:
                raise KeyboardInterrupt
            super().change(before, after)

    with rig_at(tmp_path):
        with pytest.raises(KeyboardInterrupt):
            session(campaign, tmp_path, Stop(tmp_path / "rig"))
        before = digests(campaign)
        assert 0 < len(before) < len(PLAN.slots)
        session(campaign, tmp_path)
        after = digests(campaign)
    assert before.items() <= after.items()
    assert missing_slots(PLAN, campaign) == [] and len(after) == len(PLAN.slots)


def test_a_second_capture_is_told_so(campaign, tmp_path):
    with rig_at(tmp_path), SerialLink(str(tmp_path / "rig"), PLAN.timing, PLAN.link):
        with pytest.raises(InputError, match="another program holds it"):
            session(campaign, tmp_path)
        with CampaignStore(campaign), pytest.raises(InputError, match="another capture"):
            CampaignStore(campaign).__enter__()


def test_what_a_crash_left_is_finished_or_kept_aside(campaign, tmp_path):
    with rig_at(tmp_path):
        _, watch = session(campaign, tmp_path)
    log = watch.paths[0]
    record = campaign / "capture" / f"{log.stem}.json"
    staging = tmp_path / "camp.capture" / "staging"
    whole = log.read_bytes()
    # after the record was complete: the run is finished, whether or not its record was copied already
    log.rename(staging / log.name)
    (staging / record.name).write_bytes(record.read_bytes())
    (staging / ".half.npy").write_bytes(b"half")
    with CampaignStore(campaign):
        pass
    assert log.read_bytes() == whole and record.is_file()
    assert not list(staging.iterdir())
    assert [path.name for path in (tmp_path / "camp.capture" / "unfinished").iterdir()] == ["half.npy"]
    # before: a log without a record never was a run
    log.rename(staging / log.name)
    record.unlink()
    with CampaignStore(campaign):
        pass
    assert not log.exists()
    assert len(missing_slots(PLAN, campaign)) == 1


def test_an_existing_run_is_never_replaced(campaign, tmp_path):
    with rig_at(tmp_path):
        _, watch = session(campaign, tmp_path)
    recording = read_log(watch.paths[0])
    before = watch.paths[0].read_bytes()
    with CampaignStore(campaign) as store, pytest.raises(InputError, match="there already"):
        store.add(recording, watch.paths[0].stem, ".csv", {"plan": "p"})
    assert watch.paths[0].read_bytes() == before


@pytest.mark.timeout(120)
def test_killed_at_random_moments_it_loses_no_finished_run(campaign, tmp_path):
    rng = np.random.default_rng(5)
    (tmp_path / "plan.yaml").write_text(json.dumps(DOCUMENT))
    command = [
        sys.executable, "-m", "eaclutch", "capture", "--plan", "plan.yaml", "--campaign", "camp",
        "--port", "rig", "--emulated", "--no-pictures",
    ]  # fmt: skip
    with rig_at(tmp_path) as rig:
        seen = {}
        for trial in range(4):
            with subprocess.Popen(
                command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            ) as host:
                if trial < 3:
                    wait_for_work(rig, len(rig.sent))
                    time.sleep(rng.uniform(0.0, 0.4))
                    os.kill(host.pid, signal.SIGKILL)
                assert host.wait() == (-signal.SIGKILL if trial < 3 else 0) or trial < 3
            found = digests(campaign) if (campaign / "tensile").is_dir() else {}
            assert seen.items() <= found.items()
            assert set(found.values()) <= {sent.sha256 for sent in rig.sent}
            assert not [p for p in campaign.rglob("*") if p.name.startswith(".") or p.stat().st_size == 0]
            seen = found
    assert missing_slots(PLAN, campaign) == []
    assert len(seen) == len(PLAN.slots)


def wait_for_work(rig, before, seconds=30.0):
    end = time.monotonic() + seconds
    while len(rig.sent) == before and time.monotonic() < end:
        time.sleep(0.01)


def test_store_needs_a_campaign(tmp_path):
    with pytest.raises(InputError, match=r"campaign\.yaml"):
        CampaignStore(Path(tmp_path)).__enter__()
