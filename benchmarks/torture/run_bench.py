"""Whole runs of a tiny campaign, in working directories of their own: to be killed, starved and compared."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests")]

from eaclutch.manifest import content_hash, verify  # noqa: E402
from workflow.tiny import QUICK, tiny_campaign  # noqa: E402

KINDS = (".csv", ".json", ".nc", ".html")
LONGEST = 1800.0  # s: a run that takes longer hangs


class Bench:
    """A folder with the tiny campaign, its config and as many working directories as trials."""

    def __init__(self, folder: Path, seed: int):
        self.folder, self.rng = folder, np.random.default_rng(seed)
        if not (folder / "tiny").exists():
            tiny_campaign(folder / "tiny")
        self.config = folder / "quick.yaml"
        self.config.write_text(yaml.safe_dump(QUICK | {"campaign": "tiny"}))
        self.wall = 0.0
        self.reference: dict[str, str] = {}

    def start(self, work: Path, config: Path | None = None, targets: Sequence[str] = ()) -> subprocess.Popen:
        """The run (to ``targets`` only, if any), as the leader of its own process group."""
        work.mkdir(exist_ok=True)
        command = [sys.executable, "-m", "snakemake", "-s", str(ROOT / "Snakefile"), "--cores", "2"]
        command += ["--configfile", str(config or self.config), *(["--", *targets] if targets else [])]
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
        with (self.folder / f"{work.name}.log").open("ab") as log:
            return subprocess.Popen(
                command, cwd=work, stdout=log, stderr=log, start_new_session=True, env=environment
            )

    def finish(self, work: Path, config: Path | None = None, targets: Sequence[str] = ()) -> int:
        """Run to the end; the exit status."""
        return self.start(work, config, targets).wait(LONGEST)

    def run_reference(self) -> int:
        """The undisturbed run that all others are compared with; ends the trials where even that fails."""
        work = self.folder / "reference"
        started = time.monotonic()
        status = self.finish(work)
        # a kept folder holds a finished run, which ends at once the second time
        known = self.folder / "undisturbed_s"
        if not known.exists() and status == 0:
            known.write_text(str(time.monotonic() - started))
        if status:
            print(self.output(work)[-6000:], file=sys.stderr)
            sys.exit("the undisturbed run fails")
        self.wall = float(known.read_text())
        self.reference = state(work)
        return status

    def killed(self, work: Path, after: float, config: Path | None = None) -> bool:
        """Start, kill the whole group after so many seconds; whether there was something to kill."""
        run = self.start(work, config)
        try:
            run.wait(after)
            return False
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()
            return True

    def moment(self) -> float:
        """A random time within a run [s]."""
        return float(self.rng.uniform(1.0, 1.1 * self.wall))

    def output(self, work: Path) -> str:
        """What the runs have printed; empty before the first start."""
        log = self.folder / f"{work.name}.log"
        return log.read_text(errors="replace") if log.exists() else ""

    def last_lines(self, work: Path) -> list[str]:
        """The error lines in the runs' output."""
        found = [line for line in self.output(work).splitlines() if line.startswith("eaclutch: error:")]
        return [line.replace(str(self.folder), "<folder>") for line in found]


def state(work: Path) -> dict[str, str]:
    """Content of all results but logs."""
    results = work / "results" / "tiny"
    return {
        str(path.relative_to(results)): content_hash(path)
        for path in sorted(results.rglob("*"))
        if path.suffix in KINDS and "logs" not in path.parts and not path.name.startswith(".")
    }


def different_files(work: Path, reference: dict[str, str]) -> list[str]:
    """Names of results that are not as in the reference."""
    found = state(work)
    return sorted(name for name in {*found, *reference} if found.get(name) != reference.get(name))


def differences(work: Path, reference: dict[str, str]) -> list[str]:
    """Names of results that are not as in the reference; the manifest is checked too."""
    return different_files(work, reference) + verify(work / "results" / "tiny")
