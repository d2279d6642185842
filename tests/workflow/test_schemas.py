"""What comes out of a run is what workflow/schemas says (checked on the tiny campaign by its end-to-end test)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd
import yaml
from jsonschema import Draft202012Validator

from workflow.tiny import ROOT

DOCUMENTS = {
    "capture.json": "capture",
    "manifest.json": "manifest",
    "quality.json": "quality",
    "observables.json": "observables",
    "posterior/summary.json": "summary",
    "posterior/force.gate.json": "gate",
    "predict/coverage.json": "coverage",
    "diagnosis/gap.json": "gap",
    "diagnosis/diagnosis.json": "diagnosis",
}
FOLDERS = {"diagnosis/candidates": "candidate"}
TABLES = {"runs.csv": "runs", "runs_published.csv": "runs_published", "predict/runs.csv": "predictions"}


def schema(name: str) -> Any:
    """The schema of a result, from its .yaml or .json file."""
    path = next((ROOT / "workflow" / "schemas").glob(f"{name}.schema.*"))
    return yaml.safe_load(path.read_text())


def departures(results: Path) -> list[str]:
    """How the files of a results folder depart from their schemas."""
    found = []
    kept = [(str(path.relative_to(results)), name) for folder, name in FOLDERS.items()
            for path in sorted((results / folder).glob("*.json"))]  # fmt: skip
    assert kept
    for file, name in [*DOCUMENTS.items(), *kept]:
        errors = Draft202012Validator(schema(name)).iter_errors(json.loads((results / file).read_text()))
        found += [
            f"{file}, {'.'.join(map(str, error.absolute_path))}: {error.message[:200]}" for error in errors
        ]
    for file, name in TABLES.items():
        text = {
            key: str for key, part in schema(name)["properties"].items() if "string" in str(part.get("type"))
        }
        table = pd.read_csv(results / file, dtype=text, true_values=["true"], false_values=["false"])
        rows = table.astype(object).where(table.notna(), None).to_dict("records")
        validator = Draft202012Validator(schema(name))
        for number, row in enumerate(rows):
            found += [
                f"{file}, row {number + 2}: {error.message[:200]}" for error in validator.iter_errors(row)
            ]
    return found


def test_every_schema_is_valid() -> None:
    paths = sorted((ROOT / "workflow" / "schemas").glob("*.schema.*"))
    assert len(paths) >= 12
    for path in paths:
        Draft202012Validator.check_schema(yaml.safe_load(path.read_text()))
