"""Capture, its check and its plan as commands, against the emulated rig as a command."""

import json
import signal
import subprocess
import sys
import time

import pytest
import yaml

PLAN = {
    "name": "p", "repeats": 1, "retries": 9, "travel_mm": 0.2, "speed_mm_s": 2,
    "factors": {"voltage_v": [200, 300], "frequency_hz": [100]},
    "rig": {"before_s": 0.02, "after_s": 0.02, "silence_margin_s": 1, "idle_s": 0.2},
}  # fmt: skip


def eaclutch(*arguments, cwd):
    return subprocess.run(
        [sys.executable, "-m", "eaclutch", *arguments], cwd=cwd, capture_output=True, text=True
    )


@pytest.fixture
def bench(tmp_path):
    (tmp_path / "camp").mkdir()
    (tmp_path / "camp" / "campaign.yaml").write_text("name: camp\n")
    (tmp_path / "plan.yaml").write_text(yaml.safe_dump(PLAN))
    return tmp_path


def check(bench, source="serial"):
    settings = json.dumps({"capture": {"source": source, "plan": "plan.yaml"}})
    return eaclutch(
        "capture-check", "--campaign", "camp", "--settings", settings, "--output", "out.json", cwd=bench
    )


@pytest.mark.timeout(120)
def test_a_campaign_is_captured_from_the_emulated_rig(bench):
    done = check(bench)
    assert done.returncode == 1
    assert "2 of 2 runs are missing (1 x 200 V, 100 Hz, brass 2 mm, no weight" in done.stderr
    assert "eaclutch capture --plan plan.yaml --campaign camp" in done.stderr
    command = [
        sys.executable,
        "-m",
        "eaclutch",
        "emulate",
        "--link",
        "rig",
        "--campaign",
        "camp",
        "--plan",
        "plan.yaml",
    ]
    with subprocess.Popen([*command, "--synthetic"], cwd=bench, stdout=subprocess.PIPE, text=True) as rig:
        end = time.monotonic() + 30
        while not (bench / "rig").exists() and time.monotonic() < end:
            time.sleep(0.05)
        arguments = ("--plan", "plan.yaml", "--campaign", "camp", "--port", "rig")
        unattended = eaclutch("capture", *arguments, "--unattended", cwd=bench)
        captured = eaclutch("capture", *arguments, "--emulated", cwd=bench)
        again = eaclutch("capture", *arguments, "--emulated", cwd=bench)
        rig.send_signal(signal.SIGINT)
        assert rig.wait(20) == 0
    assert unattended.returncode == 1 and unattended.stderr.splitlines()[-1].startswith(
        "eaclutch: error: capture: "
    )
    assert captured.returncode == 0, captured.stderr
    assert "0 runs captured" in again.stdout
    logs = sorted((bench / "camp" / "tensile").iterdir())
    assert len(logs) == 2
    assert len(list((bench / "camp.capture" / "pictures").glob("*.png"))) == 2
    done = check(bench)
    assert done.returncode == 0, done.stderr
    assert len(json.loads((bench / "out.json").read_text())["runs"]) == 2


def test_a_diagnosis_is_turned_into_a_plan(bench):
    suggestion = {"voltage_v": 300, "frequency_hz": 1, "width_mm": 2, "preload_n": 0.1, "runs": 5}
    (bench / "d.json").write_text(json.dumps({"campaign": "camp", "next_experiment": [suggestion]}))
    arguments = ("capture-plan", "--from", "d.json", "--campaign", "camp", "--output", "next.yaml")
    done = eaclutch(*arguments, cwd=bench)
    assert done.returncode == 0, done.stderr
    assert yaml.safe_load((bench / "next.yaml").read_text())["conditions"][0]["repeats"] == 5
    assert "is there already" in eaclutch(*arguments, cwd=bench).stderr


def test_capture_without_a_rig_or_plan_is_one_line(bench):
    arguments = ("--plan", "plan.yaml", "--campaign", "camp", "--port", "/dev/no-such-port")
    done = eaclutch("capture", *arguments, cwd=bench)
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "eaclutch: error: port: /dev/no-such-port is not there; plug the rig in, or name its port with --port"
    ]
    settings = json.dumps({"capture": {"source": "simulated", "plan": None}})
    done = eaclutch(
        "capture-check", "--campaign", "camp", "--settings", settings, "--output", "o.json", cwd=bench
    )
    assert done.returncode == 1 and "capture.plan" in done.stderr
