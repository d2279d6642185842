"""A campaign small enough for every test run, and Snakemake as a user calls it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
QUICK = {
    "posterior": {"ensembles": 2, "max_steps": 100, "check_every_steps": 50, "stored_draws": 60},
    "predict": {"draws": 20},
    "observables": {"batch_size": 6},
    "diagnosis": {"candidates": ["trapped_charge"], "pairs": 0, "null_campaigns": 20},
}


def tiny_campaign(folder: Path, name: str = "tiny", runs: int = 10) -> Path:
    """The first runs of the fixture and its side benches, under another name."""
    fixture = ROOT / "data" / "fixture"
    shutil.copytree(fixture, folder, ignore=shutil.ignore_patterns("tensile"))
    (folder / "tensile").mkdir()
    for path in sorted((fixture / "tensile").iterdir())[:runs]:
        shutil.copy2(path, folder / "tensile" / path.name)
    facts = yaml.safe_load((folder / "campaign.yaml").read_text())
    (folder / "campaign.yaml").write_text(yaml.safe_dump(facts | {"name": name}))
    return folder


def call_snakemake(
    directory: Path, *arguments: str, cores: int = 2, library: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """``snakemake`` in ``directory`` on this checkout's Snakefile, with the package of ``library`` if there is one."""
    environment = os.environ | ({"PYTHONPATH": str(library)} if library else {})
    command = [
        sys.executable,
        "-m",
        "snakemake",
        "--snakefile",
        str(ROOT / "Snakefile"),
        "--cores",
        str(cores),
    ]
    return subprocess.run(
        [*command, *arguments], cwd=directory, env=environment, capture_output=True, text=True, timeout=1400
    )


def error_lines(done: subprocess.CompletedProcess[str]) -> list[str]:
    return [line for line in done.stderr.splitlines() if line.startswith("eaclutch: error:")]
