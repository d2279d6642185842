"""The page that compares two results."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from eaclutch.files import read_json, write_json
from eaclutch.reporting.compare import changes, render_comparison
from eaclutch.reporting.results import read_results


def test_what_moved_most_comes_first(results_folder: Path, tmp_path: Path) -> None:
    other = shutil.copytree(results_folder, tmp_path / "other")
    summary = read_json(other / "posterior" / "summary.json")
    mass = summary["load_cell"]["parameters"]["mass"]
    mass["mean"] += 5 * mass["sd"]
    write_json(other / "posterior" / "summary.json", summary)
    document = read_json(other / "diagnosis" / "diagnosis.json")
    document["verdict"] |= {"effects": [], "probability": 0.9}
    write_json(other / "diagnosis" / "diagnosis.json", document)
    first, second = read_results(results_folder), read_results(other)
    found = changes(first.summary, second.summary)
    assert (found[0].name, found[0].unit) == ("mass", "g")
    assert found[0].distance == pytest.approx(5 / 2**0.5)
    html = render_comparison(first, second)
    assert "explained by trapped charge" in html and "No gap that needs a missing effect" in html
    assert html.count('class="chosen"') == 1
