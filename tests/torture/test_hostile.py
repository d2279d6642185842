"""Hostile campaigns (benchmarks/torture/hostile.py) through the commands: nothing runs, nothing changes, one line."""

import subprocess
import sys

import hostile
import pytest
from hostile_campaigns import sound

from eaclutch.cli import main

MUST_BE_REFUSED = {
    "npy_pickle", "npy_is_a_pickle", "npy_absurd_shape", "npy_header_with_code", "yaml_python_tag", "yaml_aliases",
    "yaml_deep", "yaml_runs_python_in_configs", "yaml_name_leads_elsewhere", "yaml_not_finite", "yaml_absurd_numbers",
    "gz_bomb", "xz_bomb", "csv_one_endless_line", "csv_all_nan", "csv_empty", "name_with_html", "name_with_shell",
    "name_with_newline", "log_is_a_link_out", "folder_is_a_link_out", "facts_are_a_link_out", "facts_are_a_pipe",
    "workbook_formula_without_value", "workbook_laughs", "workbook_reads_a_file", "workbook_bomb",
    "spectrum_not_finite", "capacitance_not_finite", "load_cell_not_finite",
}  # fmt: skip


@pytest.mark.parametrize("name", hostile.CASES)
@pytest.mark.timeout(60)
def test_a_hostile_campaign_does_no_harm(name, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sound, "BOMB_MEGABYTES", 156)
    results = tmp_path / "work" / "results"
    results.mkdir(parents=True)
    monkeypatch.chdir(results)
    folder = tmp_path / "campaign"
    hostile.CASES[name](folder)
    before = hostile.state(folder)
    refused = False
    for command in hostile.COMMANDS:
        try:
            main([part.format(campaign=folder) for part in command])
        except SystemExit as stop:
            refused = bool(stop.code)
        if refused:
            lines = capsys.readouterr().err.splitlines()
            assert len(lines) == 1 and lines[0].startswith("eaclutch: error: ")
            break
    assert refused or name not in MUST_BE_REFUSED
    assert not list(tmp_path.rglob("canary"))
    assert hostile.state(folder) == before
    assert {path.name for path in tmp_path.iterdir()} <= {"campaign", "other", "work"}
    assert [path.name for path in (tmp_path / "work").iterdir()] == ["results"]


def test_the_recorded_run_is_a_command(tmp_path):
    done = subprocess.run(
        [sys.executable, hostile.__file__, "--output", "h.json", "yaml_python_tag", "name_with_newline"],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "refused by capture-check" in done.stdout
