"""Torture of a whole run: whatever happens to it, the same command again ends in the same results.

    python benchmarks/torture/full_run.py --kills 50 --output ../torture.json

The output lies outside the checkout: a changed checkout is another version in every report that is compared.

Trials: kill -9 of the process group at random moments, disk full, read-only campaign, results removed in the middle,
two runs at once, data and config changed between kill and resume, clock set back, a campaign that changes meanwhile.
A tiny campaign (ten runs of the fixture, short chains) is made for it. Mounting needs root: skipped with a reason else.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from datetime import date
from pathlib import Path

import yaml
from disk_trials import disk_full, read_only
from run_bench import LONGEST, Bench, differences, state

from eaclutch.files import read_json, write_json
from eaclutch.manifest import verify
from eaclutch.provenance import commit


def kills(bench: Bench, count: int) -> Iterator[dict]:
    """kill -9 at random moments, the same command again and again; each finished run is compared, then begun anew.

    Yields what has come out so far after each finished run.
    """
    done, runs, failed, different = 0, 0, 0, []
    while done < count:
        work = bench.folder / f"kill{runs}"
        while done < count and bench.killed(work, bench.moment() * 0.5):
            done += 1
        failed += bench.finish(work) != 0
        different += differences(work, bench.reference)
        runs += 1
        shutil.rmtree(work)
        yield {"kills": done, "runs_finished": runs, "resumes_failed": failed, "different": list(different)}


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
    parser.add_argument(
        "--folder", type=Path, help="kept, with the undisturbed run in it, for further trials"
    )
    parser.add_argument("trials", nargs="*", help="of " + ", ".join(TRIALS))
    chosen = parser.parse_args()
    result: dict = {"trials": {}}
    if chosen.output.exists():  # each trial keeps its own date and commit: they need not run in one go
        result = read_json(chosen.output)

    def note(name: str, found: dict) -> None:
        head = {"command": " ".join(["python benchmarks/torture/full_run.py", *sys.argv[1:]])}
        head |= {"date": date.today().isoformat(), "commit": commit()}
        result["trials"][name] = found | head
        result["different"] = sum(len(trial.get("different", ())) for trial in result["trials"].values())
        write_json(chosen.output, result)
        print(name, json.dumps(found), flush=True)

    with nullcontext(chosen.folder) if chosen.folder else tempfile.TemporaryDirectory() as folder:
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
        for found in kills(bench, chosen.kills):
            note("kills", found)
    sys.exit(bool(result["different"] or status))


if __name__ == "__main__":
    main()
