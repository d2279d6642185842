"""No diagnosing rule reaches an answer: shown on the DAG that Snakemake builds for the benchmark."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[2]


def snakemake(folder: Path, *arguments: str) -> str:
    """What Snakemake says on this checkout's Snakefile, in an empty folder."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(CHECKOUT / "Snakefile"), *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout + "\n" + done.stderr


@pytest.mark.workflow
def test_only_sealing_and_unsealing_touch_answers(tmp_path: Path) -> None:
    # a dry run on an empty folder names every input that another job makes, and every shell command
    shown = snakemake(tmp_path, "-n", "-p", "blind_small")
    touched: dict[str, bool] = {}
    for job in re.split(r"\nJob \d+: ", shown):
        if command := re.search(r"eaclutch --log \S+ blind (\w+) ", job):
            assert "Reason: " in job
            touched[command[1]] = touched.get(command[1], False) or "blind-answers" in job
    reaching = {name for name, reached in touched.items() if reached}
    assert reaching == {"plan", "seal", "unseal"}
    assert set(touched) - reaching == {"diagnose", "compare", "freeze", "report"}


@pytest.mark.workflow
def test_verdicts_are_frozen_before_answers_open(tmp_path: Path) -> None:
    graph = snakemake(tmp_path, "blind_small", "--rulegraph", "dot")
    names = dict(re.findall(r'(\d+)\[label = "([^"\\]+)', graph))
    edges = {(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", graph)}
    assert ("blind_diagnose", "blind_freeze") in edges
    assert ("blind_freeze", "blind_unseal") in edges
    assert not {("blind_plan", "blind_diagnose"), ("blind_unseal", "blind_diagnose")} & edges
