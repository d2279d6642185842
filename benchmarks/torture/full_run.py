"""Torture of a whole run: whatever happens to it, the same command again ends in the same results.

    python benchmarks/torture/full_run.py --kills 50 --output docs/measurements/torture.json

Trials: kill -9 of the process group at random moments, disk full, read-only campaign, results removed in the middle,
two runs at once, data and config changed between kill and resume, clock set back, a campaign that changes meanwhile.
A tiny campaign (ten runs of the fixture, short chains) is made for it. Mounting needs root: skipped with a reason else.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests")]

from eaclutch.files import write_json  # noqa: E402
from eaclutch.manifest import content_hash, verify  # noqa: E402
from eaclutch.provenance import commit  # noqa: E402
from workflow.tiny import QUICK, tiny_campaign  # noqa: E402

KINDS = (".csv", ".json", ".nc", ".html")
LONGEST = 1800.0  # s: a run that takes longer hangs


class Bench:
    """A folder with the tiny campaign, its config and as many working directories as trials."""

    def __init__(self, folder: Path, seed: int):
        self.folder, self.rng = folder, np.random.default_rng(seed)
        tiny_campaign(folder / "tiny")
        self.config = folder / "quick.yaml"
        self.config.write_text(yaml.safe_dump(QUICK | {"campaign": "tiny"}))
        self.wall = 0.0
        self.reference: dict[str, str] = {}

    def start(self, work: Path, config: Path | None = None) -> subprocess.Popen:
        """The run, as the leader of its own process group."""
        work.mkdir(exist_ok=True)
        command = [sys.executable, "-m", "snakemake", "-s", str(ROOT / "Snakefile"), "--cores", "2"]
        command += ["--configfile", str(config or self.config)]
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
        with (self.folder / f"{work.name}.log").open("ab") as log:
            return subprocess.Popen(
                command, cwd=work, stdout=log, stderr=log, start_new_session=True, env=environment
            )

    def finish(self, work: Path, config: Path | None = None) -> int:
        """Run to the end; the exit status."""
        return self.start(work, config).wait(LONGEST)

    def run_reference(self) -> int:
        """The undisturbed run that all others are compared with; ends the trials where even that fails."""
        work = self.folder / "reference"
        started = time.monotonic()
        status = self.finish(work)
        self.wall = time.monotonic() - started
        if status:
            print((self.folder / "reference.log").read_text(errors="replace")[-6000:], file=sys.stderr)
            sys.exit("the undisturbed run fails")
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

    def last_lines(self, work: Path) -> list[str]:
        """The error lines in the run's output."""
        text = (self.folder / f"{work.name}.log").read_text(errors="replace")
        return [line for line in text.splitlines() if line.startswith("eaclutch: error:")]


def state(work: Path) -> dict[str, str]:
    """Content of all results but logs."""
    results = work / "results" / "tiny"
    return {
        str(path.relative_to(results)): content_hash(path)
        for path in sorted(results.rglob("*"))
        if path.suffix in KINDS and "logs" not in path.parts and not path.name.startswith(".")
    }


def differences(work: Path, reference: dict[str, str]) -> list[str]:
    """Names of results that are not as in the reference; the manifest is checked too."""
    found = state(work)
    names = sorted(name for name in {*found, *reference} if found.get(name) != reference.get(name))
    return names + verify(work / "results" / "tiny")


def kills(bench: Bench, count: int) -> dict:
    """kill -9 at random moments, the same command again and again; each finished run is compared, then begun anew."""
    done, runs, failed, different = 0, 0, 0, []
    while done < count:
        work = bench.folder / f"kill{runs}"
        while done < count and bench.killed(work, bench.moment() * 0.5):
            done += 1
        failed += bench.finish(work) != 0
        different += differences(work, bench.reference)
        runs += 1
        shutil.rmtree(work)
    return {"kills": done, "runs_finished": runs, "resumes_failed": failed, "different": different}


def mounted(kind: list[str], place: Path) -> str | None:
    """Mount on ``place``; the reason why it cannot be done, or None."""
    place.mkdir(exist_ok=True)
    done = subprocess.run(["mount", *kind, str(place)], capture_output=True, text=True)
    return done.stderr.strip() or "mount failed" if done.returncode else None


def disk_full(bench: Bench) -> dict:
    """A small disk that fills up in each stage in turn, then grows; the same command then ends well."""
    place = bench.folder / "small"
    if reason := mounted(["-t", "tmpfs", "-o", "size=64k", "tmpfs"], place):
        return {"skipped": reason}
    sizes, statuses, told = [64, 256, 400, 700, 1000, 1400, 1800, 2300], [], 0
    try:
        for size in sizes:
            subprocess.run(["mount", "-o", f"remount,size={size}k", str(place)], check=True)
            statuses.append(bench.finish(place))
            told += statuses[-1] != 0
        subprocess.run(["mount", "-o", "remount,size=200m", str(place)], check=True)
        last = bench.finish(place)
        return {
            "sizes_kb": sizes, "statuses": statuses, "status_with_room": last,
            "different": differences(place, bench.reference), "error_lines": sorted(set(bench.last_lines(place)))[:8],
        }  # fmt: skip
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False)


def read_only(bench: Bench) -> dict:
    """A campaign on a read-only mount."""
    place = bench.folder / "ro"
    place.mkdir()
    if reason := mounted(["--bind", str(bench.folder / "tiny")], place / "") or mounted(
        ["-o", "remount,ro,bind"], place
    ):
        return {"skipped": reason}
    try:
        config = bench.folder / "ro.yaml"
        config.write_text(yaml.safe_dump(QUICK | {"campaign": "ro"}))
        work = bench.folder / "readonly"
        return {"status": bench.finish(work, config), "different": differences_but_manifest(work, bench)}
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False)


def differences_but_manifest(work: Path, bench: Bench) -> list[str]:
    """Where the campaign's folder has another name, the manifest and the page's provenance name it."""
    return [
        name for name in differences(work, bench.reference) if name not in ("manifest.json", "report.html")
    ]


def removed(bench: Bench) -> dict:
    """The results folder is removed while a run writes to it."""
    work = bench.folder / "removed"
    run = bench.start(work)
    time.sleep(0.6 * bench.wall)
    shutil.rmtree(work / "results", ignore_errors=True)
    first = run.wait(LONGEST)
    return {"status": first, "again": bench.finish(work), "different": differences(work, bench.reference)}


def two_at_once(bench: Bench) -> dict:
    """Two runs in one folder: one works, the other is told so in one line."""
    work = bench.folder / "two"
    first = bench.start(work)
    second = bench.start(work)
    statuses = sorted((first.wait(LONGEST), second.wait(LONGEST)))
    return {
        "statuses": statuses, "error_lines": bench.last_lines(work), "different": differences(work, bench.reference)
    }  # fmt: skip


def clock_back(bench: Bench) -> dict:
    """The clock is set back by a day between kill and resume: all that is there seems to come from the future."""
    work = bench.folder / "clock"
    bench.killed(work, 0.6 * bench.wall)
    tomorrow = time.time() + 86_400
    for path in work.rglob("*"):
        if path.is_file():
            os.utime(path, (tomorrow, tomorrow))
    return {"status": bench.finish(work), "different": differences(work, bench.reference)}


def _changed(bench: Bench, name: str, change: Callable[[Path], None], during: bool) -> dict:
    """``change(campaign)`` between kill and resume, or while the run goes on; then a fresh run to compare with."""
    campaign = bench.folder / name / "tiny"
    shutil.copytree(bench.folder / "tiny", campaign)
    config = bench.folder / name / "quick.yaml"
    config.write_text(bench.config.read_text())
    work, fresh = bench.folder / f"{name}-resumed", bench.folder / f"{name}-fresh"
    first: int | None = None
    if during:
        run = bench.start(work, config)
        time.sleep(0.4 * bench.wall)
        change(campaign)
        first = run.wait(LONGEST)
    else:
        bench.killed(work, 0.6 * bench.wall, config)
        change(campaign)
    status = bench.finish(work, config)
    bench.finish(fresh, config)
    return {
        "status_of_the_run_it_happened_to": first, "status": status, "different": differences(work, state(fresh)),
        "as_before_the_change": state(fresh) == bench.reference,
    }  # fmt: skip


def _one_log_scaled(campaign: Path) -> None:
    """One log is replaced by another recording."""
    logs = sorted((campaign / "tensile").iterdir())
    shutil.copy(logs[1], logs[0])


def _other_seed(campaign: Path) -> None:
    config = campaign.parent / "quick.yaml"
    config.write_text(yaml.safe_dump(yaml.safe_load(config.read_text()) | {"seed": 7}))


TRIALS: dict[str, Callable[[Bench], dict]] = {
    "disk_full": disk_full,
    "read_only_campaign": read_only,
    "results_removed": removed,
    "two_at_once": two_at_once,
    "clock_set_back": clock_back,
    "data_changed_between": lambda bench: _changed(bench, "data", _one_log_scaled, during=False),
    "config_changed_between": lambda bench: _changed(bench, "conf", _other_seed, during=False),
    "campaign_changes_while_read": lambda bench: _changed(bench, "live", _one_log_scaled, during=True),
}


def main() -> None:
    """Run the trials; what came out is written after each of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("trials", nargs="*", help="of " + ", ".join(TRIALS))
    chosen = parser.parse_args()
    result: dict = {
        "command": " ".join(["python benchmarks/torture/full_run.py", *sys.argv[1:]]),
        "date": date.today().isoformat(),
        "commit": commit(),
        "trials": {},
        "different": 0,
    }

    def note(name: str, found: dict) -> None:
        result["trials"][name] = found
        result["different"] += len(found.get("different", ()))
        write_json(chosen.output, result)
        print(name, json.dumps(found), flush=True)

    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder), chosen.seed)
        status = bench.run_reference()
        stands = verify(bench.folder / "reference" / "results" / "tiny")
        note(
            "undisturbed",
            {"status": status, "wall_s": bench.wall, "files": len(bench.reference), "different": stands},
        )
        for name, trial in TRIALS.items():
            if not chosen.trials or name in chosen.trials:
                note(name, trial(bench))
        if chosen.kills:
            note("kills", kills(bench, chosen.kills))
    sys.exit(bool(result["different"] or status))


if __name__ == "__main__":
    main()
