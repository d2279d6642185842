"""A run on a real Slurm against the same run at home, undisturbed and disturbed.

    benchmarks/slurm/one_node.sh start
    python benchmarks/slurm/trial.py --output docs/measurements/slurm.json
    benchmarks/slurm/one_node.sh stop

Disturbances: a job that is killed, a node that goes down and comes back, a time limit that is hit.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "benchmarks" / "torture")]

import run_bench  # noqa: E402

from eaclutch.files import write_json  # noqa: E402
from eaclutch.manifest import verify  # noqa: E402
from eaclutch.provenance import commit  # noqa: E402

SLURM = ("--profile", str(ROOT / "workflow" / "profiles" / "slurm"), "--slurm-no-account")
SLURM += ("--slurm-status-command", "squeue", "--seconds-between-status-checks", "3")
SLURM += ("--slurm-init-seconds-before-status-checks", "3")


def slurm(command: str, *arguments: str) -> str:
    """The output of one of Slurm's commands."""
    return subprocess.run([command, *arguments], capture_output=True, text=True, check=False).stdout.strip()


def started(
    bench: run_bench.Bench, name: str, *arguments: str, config: Path | None = None
) -> subprocess.Popen:
    """The run on Slurm in a working directory of its own."""
    work = bench.folder / name
    work.mkdir(exist_ok=True)
    command = [sys.executable, "-m", "snakemake", "-s", str(ROOT / "Snakefile"), *SLURM]
    command += ["--configfile", str(config or bench.config), *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    with (bench.folder / f"{name}.log").open("ab") as log:
        return subprocess.Popen(command, cwd=work, stdout=log, stderr=log, env=environment)


def running_job(run: subprocess.Popen, seconds: float = 300.0) -> str | None:
    """A job that Slurm is running for us, once there is one."""
    end = time.monotonic() + seconds
    while run.poll() is None and time.monotonic() < end:
        if jobs := slurm("squeue", "-h", "-t", "running", "-o", "%i").split():
            return jobs[0]
        time.sleep(0.5)
    return None


def outcome(bench: run_bench.Bench, name: str, run: subprocess.Popen, *happened: object) -> dict:
    """How it ended; the same command is given again where it failed."""
    statuses = [run.wait(run_bench.LONGEST)]
    while statuses[-1] and len(statuses) < 3:
        statuses.append(started(bench, name).wait(run_bench.LONGEST))
    work = bench.folder / name
    return {
        "happened_to": happened,
        "statuses": statuses,
        "different": run_bench.differences(work, bench.reference),
    }


def plain(bench: run_bench.Bench) -> dict:
    """Nothing happens."""
    begun = time.monotonic()
    found = outcome(bench, "plain", started(bench, "plain"))
    return found | {"wall_s": time.monotonic() - begun}


def job_killed(bench: run_bench.Bench) -> dict:
    """A running job is killed."""
    run = started(bench, "killed")
    job = running_job(run)
    if job:
        slurm("scancel", "--signal=KILL", job)
    return outcome(bench, "killed", run, job)


def node_down(bench: run_bench.Bench) -> dict:
    """The only node goes down while it works, and comes back."""
    run = started(bench, "down")
    job = running_job(run)
    node = slurm("sinfo", "-h", "-o", "%N")
    slurm("scontrol", "update", f"nodename={node}", "state=down", "reason=trial")
    time.sleep(15)
    slurm("scontrol", "update", f"nodename={node}", "state=resume")
    return outcome(bench, "down", run, job, node)


def time_limit(bench: run_bench.Bench) -> dict:
    """A stage that needs more than its time; with more time the same command goes on."""
    config = bench.folder / "long.yaml"
    settings = {**run_bench.QUICK, "campaign": "tiny"}
    settings["posterior"] = {**settings["posterior"], "max_steps": 200_000, "check_every_steps": 100_000}
    settings["posterior"]["ess_min"] = 100_000
    config.write_text(yaml.safe_dump(settings))
    target = "results/tiny/posterior/contact.nc"
    work = bench.folder / "limit"
    run = started(
        bench,
        "limit",
        "--retries",
        "0",
        "--set-resources",
        "posterior:runtime=1",
        "--",
        target,
        config=config,
    )
    status = run.wait(run_bench.LONGEST)
    half = (work / target).exists()
    settings["posterior"] = run_bench.QUICK["posterior"]
    config.write_text(yaml.safe_dump(settings))
    again = started(bench, "limit", config=config).wait(run_bench.LONGEST)
    return {
        "status": status, "half_file": half, "again_with_short_chains": again,
        "different": run_bench.differences(work, bench.reference),
    }  # fmt: skip


TRIALS: dict[str, Callable[[run_bench.Bench], dict]] = {
    "plain": plain, "job_killed": job_killed, "node_down": node_down, "time_limit": time_limit
}  # fmt: skip


def main() -> None:
    """Run the trials and write what came out; nothing where Slurm is not up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("trials", nargs="*", help="of " + ", ".join(TRIALS))
    chosen = parser.parse_args()
    if not shutil.which("sinfo") or not slurm("sinfo", "-h"):
        print("no trial: Slurm is not up (benchmarks/slurm/one_node.sh start)", file=sys.stderr)
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        bench = run_bench.Bench(Path(folder), 1)
        status = bench.run_reference()
        stands = verify(bench.folder / "reference" / "results" / "tiny")
        found: dict = {"at_home": {"status": status, "wall_s": bench.wall, "different": stands}}
        for name, trial in TRIALS.items():
            if not chosen.trials or name in chosen.trials:
                found[name] = trial(bench)
                print(name, json.dumps(found[name]), flush=True)
    result = {
        "command": " ".join(["python benchmarks/slurm/trial.py", *sys.argv[1:]]),
        "date": date.today().isoformat(),
        "commit": commit(),
        "slurm": slurm("sinfo", "--version"),
        "trials": found,
        "different": sum(len(trial.get("different", ())) for trial in found.values()),
    }
    write_json(chosen.output, result)
    sys.exit(bool(result["different"] or status))


if __name__ == "__main__":
    main()
