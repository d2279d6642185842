"""From raw logs to the report on a tiny campaign, and what reruns when something changes."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
import yaml

from eaclutch.manifest import content_hash, verify
from workflow.test_schemas import departures
from workflow.tiny import ROOT, call_snakemake

pytestmark = [pytest.mark.workflow, pytest.mark.timeout(1500)]


def jobs(text: str) -> dict[str, int]:
    """Rules and their number of jobs in Snakemake's first table."""
    table = re.search(r"Job stats:\njob +count\n[- ]+\n(.*?)\n\n", text + "\n\n", flags=re.DOTALL)
    rows = dict(line.rsplit(maxsplit=1) for line in table.group(1).splitlines()) if table else {}
    return {rule: int(count) for rule, count in rows.items() if rule not in ("total", "all")}


def state(folder: Path) -> dict[str, tuple[int, int]]:
    return {str(p): (p.stat().st_size, p.stat().st_mtime_ns) for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def finished(quick: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A working directory with the finished results; the campaign was only read."""
    directory = tmp_path_factory.mktemp("work")
    before = state(quick.parent / "tiny")
    done = call_snakemake(directory, "--configfile", str(quick))
    assert done.returncode == 0, done.stderr[-6000:]
    assert state(quick.parent / "tiny") == before
    return directory


def planned(directory: Path, *configs: Path, library: Path | None = None) -> dict[str, int]:
    done = call_snakemake(directory, "--dry-run", "--configfile", *map(str, configs), library=library)
    assert done.returncode == 0, done.stderr
    return jobs(done.stdout + done.stderr)


def test_the_report_is_there_and_the_manifest_holds(finished: Path) -> None:
    results = finished / "results" / "tiny"
    html = (results / "report.html").read_text()
    assert "<h1" in html and "Predicted against measured" in html and len(html) < 10_000_000
    assert len(json.loads((results / "capture.json").read_text())["runs"]) == 10
    verdict = json.loads((results / "diagnosis" / "diagnosis.json").read_text())["verdict"]
    assert set(verdict) >= {"effects", "probability", "alternatives", "why"}
    assert verify(results) == []
    (results / "runs.csv").touch()
    assert verify(results) == []


def test_what_comes_out_is_what_the_schemas_say(finished: Path) -> None:
    assert departures(finished / "results" / "tiny") == []


def test_the_engines_own_report_has_captions_with_this_runs_numbers(finished: Path, quick: Path) -> None:
    done = call_snakemake(finished, "--configfile", str(quick), "--report", "engine.html")
    assert done.returncode == 0, done.stderr[-3000:]
    page = (finished / "engine.html").read_text()
    quality = json.loads((finished / "results" / "tiny" / "quality.json").read_text())
    assert f"{quality['usable']} of {quality['runs']} runs are used" in page
    assert "Predictions of" in page


def test_the_studies_pages_and_their_captions(finished: Path, quick: Path, tmp_path: Path) -> None:
    finished = shutil.copytree(finished, tmp_path / "work")  # others compare the folder file by file
    (tmp_path / "few.yaml").write_text("sweep: {draws: 5, levels: 3}")
    wanted = ["sweep", "paper", "fea", "--configfile", str(quick), str(tmp_path / "few.yaml")]
    done = call_snakemake(finished, *wanted)
    assert done.returncode == 0, done.stderr[-3000:]
    pages = {name: (finished / f"results/tiny/{name}/report.html").read_text() for name in wanted[:3]}
    assert "The paper&#39;s trends" in pages["sweep"] and "Probability that release" in pages["sweep"]
    assert "With the paper&#39;s parameters" in pages["paper"] and "Times in the literature" in pages["paper"]
    assert "within 5 % of the field solution" in pages["fea"]
    assert all(
        "<svg" in page and "http" not in page.replace("http://www.w3.org", "") for page in pages.values()
    )
    done = call_snakemake(finished, *wanted, "--report", str(tmp_path / "all.html"))
    assert done.returncode == 0, done.stderr[-3000:]
    captions = (tmp_path / "all.html").read_text()
    assert "A design meets the limits with a probability" in captions and "above the formula" in captions


def test_verify_sees_a_changed_result(finished: Path) -> None:
    path = finished / "results" / "tiny" / "quality.json"
    text = path.read_text()
    try:
        path.write_text(text + " ")
        assert verify(path.parent) == ["result quality.json has changed"]
    finally:
        path.write_text(text)


def test_a_second_call_has_nothing_to_do(finished: Path, quick: Path) -> None:
    done = call_snakemake(finished, "--configfile", str(quick))
    assert done.returncode == 0 and "Nothing to be done" in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("change", "rerun", "kept"),
    [
        (
            {"priors": {"mass": [0.0011, 0.00004]}},
            {"posterior", "posterior_summary", "predict", "diagnosis", "report"},
            {"capture", "observables", "runs", "gap"},
        ),
        (
            {"predict": {"draws": 25}},
            {"predict", "report"},
            {"posterior", "observables", "runs", "diagnosis"},
        ),
        (
            {"observables": {"exclude": {"RUN": "burnt"}}},
            {"runs", "posterior", "predict"},
            {"capture", "observables", "gap"},
        ),
        (
            {"posterior": {"max_steps": 101}},
            {"posterior", "predict"},
            {"capture", "observables", "runs", "gap", "diagnosis_gap"},
        ),
    ],
    ids=["prior", "draws", "dropped run", "sampler"],
)
def test_an_edit_reruns_only_what_depends_on_it(
    finished: Path, quick: Path, tmp_path: Path, change: dict, rerun: set[str], kept: set[str]
) -> None:
    run = json.loads((finished / "results" / "tiny" / "capture.json").read_text())["runs"][0]["run"]
    (tmp_path / "edit.yaml").write_text(yaml.safe_dump(change).replace("RUN", run))
    found = planned(finished, quick, tmp_path / "edit.yaml")
    assert rerun <= set(found)
    assert not kept & set(found)


def test_one_prior_reruns_its_own_stage_and_what_follows(finished: Path, quick: Path, tmp_path: Path) -> None:
    (tmp_path / "edit.yaml").write_text("priors: {mass: [0.0011, 0.00004]}")
    assert planned(finished, quick, tmp_path / "edit.yaml")["posterior"] == 2  # load_cell, force


@pytest.mark.parametrize(
    ("edited", "rerun", "kept"),
    [
        ("inference/predict_campaign.py", {"predict", "report"}, {"posterior", "observables"}),
        ("rig/observables/slip.py", {"observables"}, {"capture", "gap"}),
        ("reporting/templates/report.html.j2", {"report"}, {"predict", "posterior", "observables"}),
        (None, set(), {"predict", "posterior", "observables"}),
    ],
    ids=["prediction", "observable", "template", "nothing"],
)
def test_an_edit_in_the_library_reruns_only_what_rests_on_it(
    finished: Path, quick: Path, tmp_path: Path, edited: str | None, rerun: set[str], kept: set[str]
) -> None:
    shutil.copytree(ROOT / "src" / "eaclutch", tmp_path / "eaclutch")
    if edited:
        with (tmp_path / "eaclutch" / edited).open("a") as stream:
            stream.write("\n# another line\n")
    found = planned(finished, quick, library=tmp_path)
    assert rerun <= set(found)
    assert not kept & set(found)


@pytest.mark.parametrize("job", ["observables:batch=0", "predict:batch=0"])
def test_a_job_on_another_machine_finds_its_inputs(finished: Path, quick: Path, job: str) -> None:
    """As an executor calls it: this rule alone is known there, and what a checkpoint tells it must be an input."""
    alone = ("--target-jobs", job, "--allowed-rules", job.split(":")[0], "--dry-run")
    done = call_snakemake(finished, "--configfile", str(quick), *alone)
    assert done.returncode == 0, done.stderr[-3000:]


def test_one_core_gives_the_same_numbers_as_two(finished: Path, quick: Path, tmp_path: Path) -> None:
    done = call_snakemake(tmp_path, "--configfile", str(quick), cores=1)
    assert done.returncode == 0, done.stderr[-6000:]
    one, two = tmp_path / "results" / "tiny", finished / "results" / "tiny"
    names = {
        str(path.relative_to(two))
        for path in two.rglob("*")
        if path.suffix in (".csv", ".json", ".nc", ".html")
    }
    assert names == {
        str(p.relative_to(one)) for p in one.rglob("*") if p.suffix in (".csv", ".json", ".nc", ".html")
    }
    different = {name for name in names if content_hash(one / name) != content_hash(two / name)}
    assert not different
