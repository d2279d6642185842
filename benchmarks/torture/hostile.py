"""Campaigns that want to do harm, each as a folder: code in data, bombs, names and links that lead elsewhere.

    python benchmarks/torture/hostile.py --output docs/measurements/hostile.json

Each goes through the commands that read a campaign. Nothing may execute (a canary file would tell), nothing may be
written outside the results, memory and time stay bounded, and what is refused is refused in one line.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path

from hostile_campaigns import CASES

from eaclutch.files import write_json
from eaclutch.provenance import commit

MEMORY_LIMIT = 1 << 30  # bytes resident
TIME_LIMIT = 60.0  # s a command
COMMANDS = (
    ("capture-check", "--campaign", "{campaign}", "--output", "capture.json"),
    ("observables", "--campaign", "{campaign}", "--capture", "capture.json", "--batch", "0", "--output", "batch.csv",
     "--published", "published.csv", "--traces", "traces.npz"),
    ("gap", "--campaign", "{campaign}", "--gap", "gap.csv", "--spectra", "spectra.csv", "--bursts", "bursts.csv"),
)  # fmt: skip


def run(build: Callable[[Path], None]) -> dict:
    """What became of one hostile campaign."""
    with tempfile.TemporaryDirectory() as place:
        folder, results = Path(place, "campaign"), Path(place, "work", "results")
        results.mkdir(parents=True)
        build(folder)
        before = state(folder)
        outcome, peak, slowest, faults = "read", 0, 0.0, []
        for command in COMMANDS:
            arguments = [part.format(campaign=folder) for part in command]
            started = time.monotonic()
            try:
                done = subprocess.run(
                    [sys.executable, "-m", "eaclutch", *arguments],
                    cwd=results, capture_output=True, text=True, timeout=TIME_LIMIT,
                )  # fmt: skip
            except subprocess.TimeoutExpired:
                faults.append(f"{command[0]} hangs")
                break
            slowest = max(slowest, time.monotonic() - started)
            peak = max(peak, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024)
            if done.returncode:
                lines = done.stderr.splitlines()
                if len(lines) != 1 or not lines[0].startswith("eaclutch: error: "):
                    faults.append(f"{command[0]}: {lines[-1:]}")
                outcome = f"refused by {command[0]}: {lines[-1][16:].replace(place, '') if lines else ''}"
                break
        if list(Path(place).rglob("canary")) or Path("canary").exists():
            faults.append("executed")
        if state(folder) != before:
            faults.append("campaign changed")
        stray = {path.name for path in Path(place).iterdir()} - {"campaign", "other", "work"}
        if stray or {path.name for path in Path(place, "work").iterdir()} != {"results"}:
            faults.append("wrote outside the results")
    return {"outcome": outcome, "faults": faults, "peak_bytes": peak, "slowest_s": slowest}


def state(folder: Path) -> list[tuple[str, int]]:
    """Every name below a folder and when it was changed."""
    return sorted((str(path), path.lstat().st_mtime_ns) for path in folder.rglob("*"))


def main() -> None:
    """Run all cases, or those named, and write what came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("cases", nargs="*")
    chosen = parser.parse_args()
    found = {}
    for name, build in CASES.items():
        if not chosen.cases or name in chosen.cases:
            found[name] = run(build)
            print(name, json.dumps(found[name]), flush=True)
    # peak_bytes is the largest child so far: what counts is that none goes beyond the limit
    peak = max(entry.pop("peak_bytes") for entry in found.values())
    result = {
        "command": f"python benchmarks/torture/hostile.py --output {chosen.output}",
        "date": date.today().isoformat(),
        "commit": commit(),
        "peak_bytes": peak,
        "faults": sum(len(entry["faults"]) for entry in found.values()) + (peak > MEMORY_LIMIT),
        "cases": found,
    }
    write_json(chosen.output, result)
    sys.exit(bool(result["faults"]))


if __name__ == "__main__":
    main()
