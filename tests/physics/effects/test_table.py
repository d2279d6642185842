"""The page and the listing say what the library is."""

from __future__ import annotations

import json
from pathlib import Path

from click.testing import CliRunner

from eaclutch.cli.physics import effects
from eaclutch.physics import effect_table
from eaclutch.physics.effects import BASE, EFFECTS, switched_on

PAGE = Path(__file__).resolve().parents[3] / "docs" / "effects.md"


def test_the_page_has_not_drifted():
    """Mend by: eaclutch effects --format markdown > docs/effects.md"""
    assert PAGE.read_text(encoding="utf-8") == effect_table.as_markdown().rstrip("\n") + "\n"


def test_listing_names_every_effect_once():
    result = CliRunner().invoke(effects, [])
    assert result.exit_code == 0
    assert [line.split()[1] for line in result.output.splitlines()] == list(EFFECTS)


def test_json_says_bounds_and_neutral():
    listed = json.loads(CliRunner().invoke(effects, ["--format", "json"]).output)
    found = {e["name"]: {p["name"]: p for p in e["parameters"]} for e in listed}
    assert found["trapped_charge"]["residual_fraction"]["neutral"] == 0.0
    assert found["trapped_charge"]["residual_fraction"]["bounds"] == [0.0, 0.98]
    assert found["trapped_charge"]["decay_time"]["neutral"] is None


def test_an_empty_list_switches_nothing_on_and_null_the_base_model():
    assert switched_on({"effects": []}) == ()
    assert switched_on({"effects": None, "without": ["air_gap"]}) == tuple(n for n in BASE if n != "air_gap")
    assert switched_on({}) == BASE
