"""The same numbers whatever the Python: the first commands of a run, by several interpreters, compared.

    python benchmarks/torture/pythons.py --output docs/measurements/pythons.json <python 3.12> ...

Each interpreter must have the pinned requirements and this package in it (`pip install --require-hashes -r
requirements.txt; pip install --no-deps -e .`); the one that runs this script is the reference. Logs to observables,
the side benches, and two stages of calibration with short chains, on the fixture.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
from run_bench import QUICK, tiny_campaign

from eaclutch.config import load_config
from eaclutch.files import write_json
from eaclutch.manifest import content_hash
from eaclutch.provenance import commit

RUNS = 6
AGREES = 1e-6  # largest relative difference: other releases of the libraries round otherwise


def commands() -> list[list[str]]:
    """Arguments of the commands, in their order; everything is written to the working directory."""
    config = load_config([], QUICK)
    settings = json.dumps({key: config[key] for key in ("posterior", "model", "priors")})
    posterior = ["--campaign", "tiny", "--results", ".", "--settings", settings, "--seed", "1"]
    found = [
        ["capture-check", "--campaign", "tiny", "--output", "capture.json"],
        ["observables", "--campaign", "tiny", "--capture", "capture.json", "--batch", "0", "--output", "batch.csv",
         "--published", "published.csv", "--traces", "traces.npz"],
        ["gap", "--campaign", "tiny", "--gap", "gap.csv", "--spectra", "spectra.csv", "--bursts", "bursts.csv"],
    ]  # fmt: skip
    for stage in ("dielectric", "load_cell"):
        files = ["--output", f"posterior/{stage}.nc", "--gate", f"posterior/{stage}.gate.json"]
        found.append(["posterior", stage, *posterior, *files])
    return found


def results(python: str, folder: Path) -> dict[str, str]:
    """Content of all that the commands write, by file."""
    tiny_campaign(folder / "tiny", runs=RUNS)
    (folder / "posterior").mkdir()
    for command in commands():
        subprocess.run([python, "-m", "eaclutch", *command], cwd=folder, check=True)
    return {
        str(path.relative_to(folder)): content_hash(path)
        for path in sorted(folder.rglob("*"))
        if path.suffix in (".csv", ".json", ".nc") and "tiny" not in path.parts
    }


def numbers(path: Path) -> np.ndarray:
    """All real numbers in a table or in the arrays of a .nc file, (numbers,)."""
    if path.suffix == ".csv":
        table = pd.read_csv(path).select_dtypes("number")
        return table.to_numpy(dtype=float).ravel()
    found: list[np.ndarray] = []
    with h5py.File(path) as file:
        file.visititems(
            lambda _, item: (
                found.append(item[()].ravel())
                if isinstance(item, h5py.Dataset) and item.dtype.kind == "f"
                else None
            )
        )
    return np.concatenate(found)


def apart(one: Path, other: Path) -> float:
    """Largest relative difference of the numbers in two files; infinite where they are not as many."""
    if one.suffix == ".json" or not (one.exists() and other.exists()):
        return math.inf
    a, b = numbers(one), numbers(other)
    if a.shape != b.shape or (np.isnan(a) != np.isnan(b)).any():
        return math.inf
    scale = np.maximum(np.abs(a), np.abs(b))
    return float(np.max(np.abs(a - b)[scale > 0] / scale[scale > 0]))


def main() -> None:
    """Run the commands by each interpreter and write which files differ from the reference's."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("pythons", nargs="+", help="interpreters to compare with the one that runs this")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        reference = results(sys.executable, Path(place, "reference"))
        different = {}
        for number, python in enumerate(chosen.pythons):
            version = subprocess.run(
                [python, "-VV"], capture_output=True, text=True, check=True
            ).stdout.split()[1]
            found = results(python, Path(place, str(number)))
            names = sorted({*found, *reference})
            different[version] = {
                name: apart(Path(place, "reference", name), Path(place, str(number), name))
                for name in names
                if found.get(name) != reference.get(name)
            }
            print(version, len(found), "files, different:", different[version], flush=True)
    result = {
        "command": "python benchmarks/torture/pythons.py --output docs/measurements/pythons.json <pythons>",
        "date": date.today().isoformat(),
        "commit": commit(),
        "reference": platform.python_version(),
        "files": sorted(reference),
        "largest_relative_difference": different,
    }
    write_json(chosen.output, result)
    sys.exit(any(size > AGREES for found in different.values() for size in found.values()))


if __name__ == "__main__":
    main()
