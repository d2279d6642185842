"""Bad input: one line, before any job where that can be known."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from eaclutch.files import hold
from workflow.tiny import call_snakemake, error_lines, tiny_campaign

pytestmark = [pytest.mark.workflow, pytest.mark.timeout(1500)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("posterior: {wolkers: 30}", ("posterior.wolkers", "not a known key")),
        ("posterior: {walkers: 30 walkers}", ("posterior.walkers", "integer")),
        ("model: {without: [gravity]}", ("model.without", "gravity")),
        ("campaign: nowhere", ("nowhere", "no such campaign folder")),
    ],
)
def test_a_wrong_config_stops_before_the_dag(tmp_path: Path, text: str, words: tuple[str, ...]) -> None:
    (tmp_path / "mine.yaml").write_text(text)
    done = call_snakemake(tmp_path, "--configfile", "mine.yaml")
    lines = error_lines(done)
    assert done.returncode != 0 and len(lines) == 1
    assert all(word in lines[0] for word in (*words, ";"))
    assert "Building DAG" not in done.stderr and not (tmp_path / "results").exists()


def test_a_wrong_bench_stops_before_the_dag(tmp_path: Path) -> None:
    folder = tiny_campaign(tmp_path / "tiny", runs=2)
    (folder / "campaign.yaml").write_text("pad: {film_thickness_mm: 0.024}")
    done = call_snakemake(tmp_path, "--config", "campaign=tiny")
    assert done.returncode != 0 and "pad.film_thickness_mm" in "".join(error_lines(done))
    assert "Building DAG" not in done.stderr


def test_results_that_another_run_makes_stop_before_the_dag_but_not_a_dry_run(tmp_path: Path) -> None:
    tiny_campaign(tmp_path / "tiny", runs=2)
    handle = hold(tmp_path / ".snakemake" / "eaclutch" / "tiny.lock")
    done = call_snakemake(tmp_path, "--config", "campaign=tiny")
    dry = call_snakemake(tmp_path, "-n", "--config", "campaign=tiny")
    os.close(handle)
    assert done.returncode != 0 and "another run makes these results" in "".join(error_lines(done))
    assert "Building DAG" not in done.stderr
    assert dry.returncode == 0 and not error_lines(dry)


def test_logs_that_cannot_be_read_give_one_line_however_many_jobs_fail(tmp_path: Path) -> None:
    folder = tiny_campaign(tmp_path / "tiny", runs=2)
    for path in list((folder / "tensile").iterdir()):
        path.rename(path.with_suffix("")) if path.suffix == ".xz" else None
    done = call_snakemake(
        tmp_path, "--config", "campaign=tiny", "observables={batch_size: 1}", "--", "results/tiny/runs.csv"
    )
    lines = error_lines(done)
    assert done.returncode != 0 and len(lines) == 1, done.stderr[-3000:]
    assert "_brass.csv, row 1" in lines[0] and not (tmp_path / "results" / "tiny" / "runs.csv").exists()


def test_another_campaign_of_the_same_name_is_refused(tmp_path: Path) -> None:
    first = tiny_campaign(tmp_path / "first", runs=2)
    assert (
        call_snakemake(
            tmp_path, "--config", f"campaign={first}", "--", "results/tiny/capture.json"
        ).returncode
        == 0
    )
    second = tiny_campaign(tmp_path / "second", runs=2)
    logs = sorted((second / "tensile").iterdir())
    shutil.copy(logs[0], logs[1])
    done = call_snakemake(tmp_path, "--config", f"campaign={second}", "--", "results/tiny/capture.json")
    assert done.returncode != 0 and "another campaign of this name" in "".join(error_lines(done))
    shutil.copytree(first, tmp_path / "moved")
    moved = call_snakemake(tmp_path, "--config", "campaign=moved", "--", "results/tiny/capture.json")
    assert moved.returncode == 0
