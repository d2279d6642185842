"""From a log to its observables: time a run on one core, by format, and the job's peak memory.

    python benchmarks/extractor_speed.py <folder with .csv.xz logs> --runs 20

prints and records docs/measurements/extractor_speed.json. Processor time, so that a busy machine does not count.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from measurement import record

from eaclutch.records import Bench
from eaclutch.rig.extract import extract
from eaclutch.rig.logs import EXTENSIONS, read_log, write_log


def peak_memory(logs: list[Path]) -> float:
    """Peak resident memory [MiB] of the workflow's job on these logs: two commands, the larger one counts."""
    with tempfile.TemporaryDirectory() as place:
        campaign = Path(place, "campaign")
        (campaign / "tensile").mkdir(parents=True)
        (campaign / "campaign.yaml").write_text("name: speed\n")
        for log in logs:
            shutil.copy(log, campaign / "tensile")
        check = ["capture-check", "--campaign", "campaign", "--settings",
                 json.dumps({"observables.batch_size": len(logs)}), "--output", "capture.json"]  # fmt: skip
        extract_all = ["observables", "--campaign", "campaign", "--capture", "capture.json", "--batch", "0",
                       "--output", "o.csv", "--published", "p.csv", "--traces", "t.npz"]  # fmt: skip
        for command in (check, extract_all):
            subprocess.run([sys.executable, "-m", "eaclutch", *command], cwd=place, check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--runs", type=int, default=20)
    chosen = parser.parse_args()
    logs = sorted(chosen.folder.glob("*.csv.xz"))
    logs = logs[:: max(1, len(logs) // chosen.runs)][: chosen.runs]
    bench, times = Bench("speed"), {}
    with tempfile.TemporaryDirectory() as place:
        for extension in EXTENSIONS:
            spent = []
            for log in logs:
                recording = read_log(log)
                path = write_log(recording, Path(place) / f"{recording.settings.run}{extension}")
                start = time.process_time()
                extract(read_log(path), bench)
                spent.append(time.process_time() - start)
                path.unlink()
            times[extension] = {"median_ms": 1e3 * np.median(spent[1:]), "worst_ms": 1e3 * np.max(spent[1:])}
            print(extension, times[extension])
    peak = peak_memory(logs)
    print(f"peak memory {peak:.0f} MiB")
    command = f"python benchmarks/extractor_speed.py <published tensile folder> --runs {chosen.runs}"
    record(
        "extractor_speed", command, {"runs": len(logs), "log_to_observables": times, "peak_memory_mib": peak}
    )


if __name__ == "__main__":
    main()
