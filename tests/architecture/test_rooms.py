"""Who may import whom (docs/architecture.md), and the size of files."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "eaclutch"
ROOT = PACKAGE.parents[1]
# Ground floor that every room may stand on.
GROUND = {"records", "files"}
ROOMS = {
    "config": set(),
    "rig": {"config"},
    "physics": set(),
    "simulation": {"physics", "rig", "config"},
    "inference": {"physics"},
    "diagnosis": {"inference", "simulation", "physics", "rig.table", "rig.zero"},
    "blind": {"rig.logs", "rig.log_names", "config"},
    "reporting": {"provenance", "diagnosis.settings"},
    "studies": {"physics", "inference"},
}
ONLY_HERE = {
    "arviz": {"inference/storage.py"},
    "emcee": {"inference"},
    "matplotlib": {"reporting"},
    "jinja2": {"reporting"},
    "snakemake": set(),
    "serial": {"rig/link", "cli"},
}
LONGEST = 350


def imports(path: Path) -> list[str]:
    """Dotted names that a file imports, at the top or inside functions."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports relatively"
            found += [f"{node.module}.{alias.name}" for alias in node.names]
    return found


FILES = sorted(PACKAGE.rglob("*.py"))


def below(name: str, allowed: set[str]) -> bool:
    return any(name == part or name.startswith(part + ".") for part in allowed)


@pytest.mark.parametrize("room", ROOMS)
def test_rooms_import_only_what_stands_in_their_row(room: str) -> None:
    strangers = []
    for path in (PACKAGE / room).rglob("*.py"):
        for name in imports(path):
            if name.split(".")[0] == "eaclutch" and name != "eaclutch":
                inside = name.removeprefix("eaclutch.")
                if not below(inside, ROOMS[room] | GROUND | {room}):
                    strangers.append(f"{path.relative_to(PACKAGE)}: {name}")
    assert not strangers


def test_every_room_has_a_row() -> None:
    rooms = {path.name for path in PACKAGE.iterdir() if path.is_dir() and (path / "__init__.py").is_file()}
    assert rooms == set(ROOMS) | {"cli"}


def test_nothing_imports_the_command_line() -> None:
    for path in FILES:
        if "cli" not in path.relative_to(PACKAGE).parts and path.name != "__main__.py":
            assert not [name for name in imports(path) if below(name, {"eaclutch.cli"})], path


@pytest.mark.parametrize("library", ONLY_HERE)
def test_some_libraries_have_one_home(library: str) -> None:
    for path in FILES:
        if below_any := [name for name in imports(path) if name.split(".")[0] == library]:
            place = path.relative_to(PACKAGE).as_posix()
            assert any(place.startswith(home) for home in ONLY_HERE[library]), (place, below_any)


def test_no_pickle_and_no_unsafe_yaml() -> None:
    for path in FILES:
        text = path.read_text(encoding="utf-8")
        assert not [name for name in imports(path) if name.split(".")[0] in {"pickle", "dill", "joblib"}], (
            path
        )
        assert "allow_pickle=True" not in text, path
        assert "yaml.unsafe" not in text and "yaml.full_load" not in text, path


def test_files_are_short_and_named_for_what_they_do() -> None:
    sources = [
        *FILES,
        *ROOT.glob("workflow/rules/*.smk"),
        *(ROOT / "tests").rglob("*.py"),
        ROOT / "Snakefile",
    ]
    long = {
        str(path.relative_to(ROOT)): n
        for path in sources
        if (n := len(path.read_text().splitlines())) > LONGEST
    }
    assert not long
    drawers = {"utils", "util", "helpers", "helper", "misc", "common"}
    assert not [path for path in FILES if path.stem in drawers]
    assert len((ROOT / "Snakefile").read_text().splitlines()) < 60


def test_rule_files_hold_no_science() -> None:
    for path in ROOT.glob("workflow/rules/*.smk"):
        lines = [line.split("#")[0].strip() for line in path.read_text().splitlines()]
        for name in ("numpy", "scipy", "pandas", "numba", "emcee"):
            assert not any(line.startswith((f"import {name}", f"from {name}")) for line in lines), path


def test_schemas_are_closed_and_described() -> None:
    import yaml

    def check(schema: object, where: str) -> None:
        if isinstance(schema, dict):
            if "properties" in schema:
                assert "additionalProperties" in schema, f"{where} is open"
                for name, part in schema["properties"].items():
                    described = isinstance(part, dict) and (set(part) & {"description", "$ref", "const"})
                    assert described or "$defs" in where, f"{where}.{name} is not described"
            for name, part in schema.items():
                check(part, f"{where}.{name}")
        elif isinstance(schema, list):
            for part in schema:
                check(part, where)

    found = sorted(ROOT.glob("workflow/schemas/*.schema.yaml"))
    assert found
    for path in found:
        check(yaml.safe_load(path.read_text()), path.name)
