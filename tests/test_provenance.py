"""A rule's code hash changes with what the rule imports, and with nothing else."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from eaclutch import provenance
from eaclutch.provenance import code_hash


@pytest.fixture
def edited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """A copy of the package, and a way to edit a file of it."""
    copy = tmp_path / "eaclutch"
    shutil.copytree(Path(provenance.__file__).parent, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(provenance, "_PACKAGE", copy)

    def edit(name: str) -> None:
        path = copy / name
        path.write_text(path.read_text() + "\n# edited\n")

    return edit


def hashes() -> dict[str, str]:
    return {
        "logs": code_hash(["rig.logs"]),
        "batch": code_hash(["rig.batch"]),
        "model": code_hash(["physics.model"], ["air_gap"]),
        "candidate": code_hash(["physics.model"], ["air_gap", "trapped_charge"]),
        "page": code_hash(["reporting.page"]),
        "gap": code_hash(["rig.gap", "rig.capacitance", "rig.spectra", "rig.load_cell", "cli.rig"]),
    }


@pytest.mark.parametrize(
    ("file", "changed"),
    [
        ("rig/logs.py", {"logs", "batch"}),
        ("rig/observables/release.py", {"batch"}),
        ("physics/laws.py", {"model", "candidate"}),
        ("physics/effects/trapped_charge.py", {"candidate"}),
        ("physics/effects/gap_tilt.py", set()),
        ("reporting/words.py", {"page"}),
        ("rig/spectra.py", {"gap"}),
        ("reporting/templates/report.css", {"page"}),
    ],
)
def test_an_edit_changes_the_hashes_of_what_imports_it(
    edited: Callable[[str], None], file: str, changed: set[str]
) -> None:
    before = hashes()
    edited(file)
    after = hashes()
    assert {name for name in before if before[name] != after[name]} == changed


def test_a_module_that_is_not_there_is_an_error() -> None:
    with pytest.raises(ValueError, match="no module"):
        code_hash(["rig.nothing"])
