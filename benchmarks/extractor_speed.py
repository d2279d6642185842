"""From a log to its observables: time a run on one core, by format, and the process's peak memory.

    python benchmarks/extractor_speed.py <folder with .csv.xz logs> --runs 20

prints and records docs/measurements/extractor_speed.json. Processor time, so that a busy machine does not count.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from measurement import record

from eaclutch.records import Bench
from eaclutch.rig.extract import extract
from eaclutch.rig.logs import EXTENSIONS, read_log, write_log


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
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"peak memory {peak:.0f} MiB")
    command = f"python benchmarks/extractor_speed.py <published tensile folder> --runs {chosen.runs}"
    record(
        "extractor_speed", command, {"runs": len(logs), "log_to_observables": times, "peak_memory_mib": peak}
    )


if __name__ == "__main__":
    main()
