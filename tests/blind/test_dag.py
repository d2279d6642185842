"""No diagnosing rule reaches an answer: shown on the DAG that Snakemake builds for the benchmark."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[2]
OPENERS = {"blind_plan", "blind_seal", "blind_unseal"}


@pytest.mark.workflow
def test_only_sealing_and_unsealing_touch_answers(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "snakemake", "-n", "-p", "blind_small", "unseal", "--directory", str(tmp_path),
               "--snakefile", str(CHECKOUT / "Snakefile"), "--forceall"]  # fmt: skip
    shown = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True).stdout
    jobs = re.split(r"\n(?=rule |localrule )", shown)
    touched: dict[str, bool] = {}
    for job in jobs:
        if name := re.match(r"(?:local)?rule (\w+):", job):
            touched[name[1]] = touched.get(name[1], False) or "blind-answers" in job
    assert {"blind_seal", "blind_diagnose", "blind_freeze", "blind_unseal", "blind_report"} <= set(touched)
    assert {name for name, reached in touched.items() if reached} <= OPENERS
    assert touched["blind_seal"] and touched["blind_unseal"]


@pytest.mark.workflow
def test_verdicts_are_frozen_before_answers_open(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "snakemake", "--rulegraph", "blind_small", "--directory", str(tmp_path),
               "--snakefile", str(CHECKOUT / "Snakefile")]  # fmt: skip
    graph = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True).stdout
    names = dict(re.findall(r'(\d+)\[label = "([^"\\]+)', graph))
    edges = {(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", graph)}
    assert ("blind_diagnose", "blind_freeze") in edges
    assert ("blind_freeze", "blind_unseal") in edges
    assert ("blind_plan", "blind_diagnose") not in edges
    assert ("blind_unseal", "blind_diagnose") not in edges
