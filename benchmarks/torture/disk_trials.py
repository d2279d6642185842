"""Trials with mounts of their own: a disk that is full when a stage writes, a campaign that cannot be written to."""

from __future__ import annotations

import shutil
import subprocess
from contextlib import suppress
from pathlib import Path

import yaml
from run_bench import QUICK, Bench, differences, different_files

STAGES = (
    "capture.json", "observables/batch_0.csv", "gap.csv", "posterior/dielectric.nc", "runs.csv", "diagnosis/gap.json",
    "predict/runs.csv", "report.html",
)  # fmt: skip


def mounted(kind: list[str], place: Path) -> str | None:
    """Mount on ``place``; the reason why it cannot be done, or None."""
    place.mkdir(exist_ok=True)
    done = subprocess.run(["mount", *kind, str(place)], capture_output=True, text=True)
    return done.stderr.strip() or "mount failed" if done.returncode else None


def disk_full(bench: Bench) -> dict:
    """The disk is full when a stage is to write; with room the same command makes what the undisturbed run made."""
    place = bench.folder / "small"
    if reason := mounted(["-t", "tmpfs", "-o", "size=60m", "tmpfs"], place):
        return {"skipped": reason}
    found, different = {}, []
    try:
        shutil.copytree(bench.folder / "reference", place, dirs_exist_ok=True)
        for stage in STAGES:
            target = Path("results", "tiny", stage)
            (place / target).unlink()
            with suppress(OSError), (place / "filler").open("wb") as filler:
                while True:
                    filler.write(bytes(4096))
                    filler.flush()
            told = len(bench.last_lines(place))
            status = bench.finish(place, targets=[str(target)])
            lines = bench.last_lines(place)[told:]
            half = (place / target).exists()
            (place / "filler").unlink()
            again = bench.finish(place, targets=[str(target)])
            found[stage] = {
                "status": status,
                "error_lines": lines,
                "half_file": half,
                "status_with_room": again,
            }
            different += [name for name in different_files(place, bench.reference) if name == stage]
        return {"stages": found, "different": different}
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False)


def read_only(bench: Bench) -> dict:
    """A campaign on a read-only mount."""
    place = bench.folder / "ro"
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
