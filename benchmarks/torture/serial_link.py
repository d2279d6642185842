"""Torture of the serial link: random faults, kill -9 of the host, and the cost of a whole run.

    python benchmarks/torture/serial_link.py --transfers 1200 --kills 50 --output docs/measurements/serial_link.json

Every accepted log is compared with what the emulated rig sent, by checksum.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from datetime import date
from pathlib import Path

import numpy as np

from eaclutch.files import write_json
from eaclutch.provenance import commit
from eaclutch.rig.link.emulator import EmulatedRig
from eaclutch.rig.link.faults import FAULTS, random_faults
from eaclutch.rig.link.plan import make_plan
from eaclutch.rig.link.protocol import BenchSetting, Columns, Command, Timing, digest, on_the_grid, render
from eaclutch.rig.link.reader import LinkSettings, SerialLink
from eaclutch.rig.link.store import columns_of, missing_slots
from eaclutch.rig.link.synthetic import SHORT, SyntheticBench
from eaclutch.rig.link.transfer import TransferFault, parse_transfer
from eaclutch.rig.logs import read_log

COMMAND = Command(0.2e-3, 2e-3)
LONGEST_ALLOWED = 30.0  # s for one transfer with everything around it: more is a hang
HARMLESS = ("swapped_digit",)  # no fault of this link (USB has its own checksum); counted apart


def transfers(count: int, seed: int) -> dict:
    """Random faults on ``count`` transfers of short records."""
    rng = np.random.default_rng(seed)
    settings = LinkSettings(20.0, silence_margin=0.4, idle=0.08, reappear=5.0)
    tally: dict[str, Counter] = {}
    slowest, wrong = 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        draw = random_faults(0.7, np.random.default_rng(seed + 1), FAULTS)
        rig = EmulatedRig(
            SyntheticBench(rng, SHORT),
            Path(folder, "rig"),
            rng=rng,
            timing=SHORT,
            speed_factor=20,
            faults=draw,
            away=0.1,
        )
        with rig, SerialLink(f"{folder}/rig*", SHORT, settings) as link:
            while len(rig.sent) < count:
                started = time.monotonic()
                try:
                    got = parse_transfer(link.transfer(COMMAND).raw, SHORT)
                except TransferFault as fault:
                    outcome = f"refused: {fault.code}"
                    link.settle(COMMAND)
                else:
                    sent = rig.sent[-1]
                    same = digest(got.columns) == sent.sha256
                    outcome = ("repaired" if got.repairs else "accepted") if same else "WRONG"
                    wrong += not same and sent.fault not in HARMLESS
                slowest = max(slowest, time.monotonic() - started)
                tally.setdefault(rig.sent[-1].fault or "none", Counter())[outcome] += 1
    return {
        "transfers": count,
        "accepted_but_different": wrong,
        "slowest_s": slowest,
        "hung": int(slowest > LONGEST_ALLOWED),
        "by_fault": {fault: dict(sorted(tally[fault].items())) for fault in sorted(tally)},
    }


def kills(count: int, seed: int) -> dict:
    """kill -9 of the capturing host at random moments, then the same command again."""
    rng = np.random.default_rng(seed)
    rig_facts = {
        "before_s": 0.02,
        "after_s": 0.02,
        "speed_factor": 10,
        "silence_margin_s": 0.4,
        "idle_s": 0.1,
    }
    document = {
        "name": "torture", "repeats": 3 * count, "retries": 9, "travel_mm": 0.2, "speed_mm_s": 2, "rig": rig_facts,
        "factors": {"voltage_v": [300]},
    }  # fmt: skip
    plan = make_plan(document, "plan")
    lost = half = foreign = killed = 0
    with tempfile.TemporaryDirectory() as folder:
        camp = Path(folder, "camp")
        camp.mkdir()
        (camp / "campaign.yaml").write_text("name: camp\n")
        Path(folder, "plan.yaml").write_text(json.dumps(document))
        command = [sys.executable, "-m", "eaclutch", "capture", "--plan", "plan.yaml", "--campaign", "camp"]
        command += ["--port", "rig", "--emulated", "--no-pictures"]
        draw = random_faults(
            0.1, np.random.default_rng(seed + 1), ("lost_packets", "garbage", "lost_line_ending")
        )
        rig = EmulatedRig(
            SyntheticBench(rng, SHORT),
            Path(folder, "rig"),
            rng=rng,
            timing=SHORT,
            speed_factor=10,
            faults=draw,
        )
        seen: dict[str, str] = {}
        with rig:
            while killed < count and missing_slots(plan, camp):
                before = len(rig.sent)
                with subprocess.Popen(
                    command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
                ) as host:
                    end = time.monotonic() + 60
                    while len(rig.sent) == before and host.poll() is None and time.monotonic() < end:
                        time.sleep(0.005)
                    time.sleep(rng.uniform(0.0, 0.5))
                    if host.poll() is None:
                        os.kill(host.pid, signal.SIGKILL)
                        killed += 1
                    host.communicate()
                found = {
                    p.name: digest(columns_of(read_log(p))) for p in sorted((camp / "tensile").glob("*"))
                }
                lost += sum(found.get(name) != value for name, value in seen.items())
                foreign += len(set(found.values()) - {sent.sha256 for sent in rig.sent})
                half += sum(
                    p.name.startswith(".") or p.stat().st_size == 0 for p in camp.rglob("*") if p.is_file()
                )
                half += sum(not (camp / "capture" / f"{p.name.removesuffix('.csv.gz')}.json").exists()
                            for p in (camp / "tensile").glob("*"))  # fmt: skip
                seen = found
    return {
        "kills": killed,
        "runs": len(seen),
        "runs_lost": lost,
        "half_files": half,
        "runs_not_as_sent": foreign,
    }


def whole_run() -> dict:
    """CPU of one whole run of 90 000 samples, and how the time of a transfer compares with the link's own."""
    rng = np.random.default_rng(3)
    bench = SyntheticBench(rng, Timing())
    command = Command(1.5e-3, 0.5e-3)
    recording = bench(BenchSetting(300.0, 1000.0, 2e-3, "brass"), command)
    columns = on_the_grid(columns_of(recording))
    raw = render(Columns(columns.time_us, columns.force, columns.flag, columns.voltage))
    started = time.process_time()
    parse_transfer(raw, Timing())
    cpu = time.process_time() - started
    found = {"samples": len(columns), "bytes": len(raw), "parse_cpu_s": cpu}
    for name, rate in (("unlimited", None), ("4_MB_per_s", 4e6)):
        with tempfile.TemporaryDirectory() as folder:
            rig = EmulatedRig(bench, Path(folder, "rig"), rng=rng, speed_factor=100, bytes_per_s=rate)
            with rig, SerialLink(f"{folder}/rig", Timing(), LinkSettings(100.0)) as link:
                own = time.process_time()
                reply = link.transfer(command)
                found[name] = {
                    "transfer_s": reply.last_byte - reply.first_byte,
                    "link_alone_s": len(reply.raw) / rate if rate else None,
                    "process_cpu_s": time.process_time() - own,  # host and emulated rig together
                }
    return found


def main() -> None:
    """Run the trials and write what came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--transfers", type=int, default=1200)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, required=True)
    chosen = parser.parse_args()
    started = time.monotonic()
    result = {
        "command": "python benchmarks/torture/serial_link.py "
        f"--transfers {chosen.transfers} --kills {chosen.kills} --seed {chosen.seed} --output {chosen.output}",
        "date": date.today().isoformat(),
        "commit": commit(),
        "transfers": transfers(chosen.transfers, chosen.seed),
        "kills": kills(chosen.kills, chosen.seed),
        "whole_run": whole_run(),
    }
    result["wall_s"] = time.monotonic() - started
    write_json(chosen.output, result)
    bad = result["transfers"]["accepted_but_different"] + result["transfers"]["hung"]
    bad += sum(result["kills"][key] for key in ("runs_lost", "half_files", "runs_not_as_sent"))
    print(json.dumps(result, indent=1))
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
