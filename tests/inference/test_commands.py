"""The commands: a campaign with nothing but logs rests on its priors, a small one runs to predictions."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from eaclutch.cli.inference import posterior, posterior_summary, predict, predictions
from eaclutch.config import load_config
from eaclutch.config.document import load_schema
from eaclutch.inference import predict_campaign, storage
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, InputError
from eaclutch.rig.table import conditions_from_runs

jsonschema = pytest.importorskip("jsonschema")
QUICK = {"walkers": 12, "check_every_steps": 100, "max_steps": 100, "stored_draws": 50, "ensembles": 2}


def settings(form="linear") -> str:
    chosen = {"posterior": QUICK, "model": {"force_multiplier_form": form}}
    config = load_config([], chosen)
    parts = {key: config[key] for key in ("posterior", "model", "priors")}
    return json.dumps(parts | {"predict.draws": 20, "predict.folds": 2})


def made_runs() -> pd.DataFrame:
    """A table of runs as the rig room writes it, from the model at its defaults with scatter."""
    rng, rows = np.random.default_rng(0), []
    for i in range(16):
        voltage = (200.0, 300.0)[i % 2]
        stamp = f"2025010{1 + (i // 8)}_10_{i:02d}_00"
        rows.append(
            {
                "run": f"{stamp}_bts_dx=1.5_v=0.5_Fpre=-1g_V={voltage:g}_f=1000_w=2_brass", "session": stamp[:8],
                "condition": f"brass_w2_t2_{voltage:g}V", "substrate": "brass", "voltage_v": voltage,
                "frequency_hz": 1000.0, "width_mm": 2.0, "thickness_mm": 2.0, "preload_n": 0.1,
                "friction_before_n": 0.05 + 0.01 * rng.random(), "friction_before_n_sd": 2e-4,
                "switch_off_force_n": np.nan,
                "switch_off_force_n_sd": np.nan, "usable": True, "flags": "", "reasons": "", "drive_duration_s": 3.0,
                "dwell_s": 0.0, "run_order": i,
            }
        )  # fmt: skip
    runs = pd.DataFrame(rows)
    found = ClutchModel(Bench("made")).predict(
        conditions_from_runs(runs), {}, ("shear_capacity_n", "release_time_90_s")
    )
    for name, values in found.values.items():
        runs[name] = values[0] * (1 + 0.03 * rng.standard_normal(16))
        runs[f"{name}_sd"] = 0.005 * values[0]
    return runs


@pytest.fixture
def campaign(tmp_path):
    folder, results = tmp_path / "made", tmp_path / "results"
    (folder / "tensile").mkdir(parents=True)
    (folder / "campaign.yaml").write_text("name: made\n")
    results.mkdir()
    runs = made_runs()
    for run in runs["run"][:1]:
        np.save(folder / "tensile" / f"{run}.npy", np.zeros((10, 4)))
    runs.to_csv(results / "runs.csv", index=False)
    columns = ["frequency_hz", "frequency_hz_sd", "damping_ratio", "damping_ratio_sd"]
    pd.DataFrame(columns=columns).to_csv(results / "bursts.csv", index=False)
    return folder, results


def call(command, *arguments):
    result = CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output


def stage(name, folder, results, seed=1, form="linear"):
    where = results / "posterior"
    call(posterior, name, "--campaign", folder, "--results", results, "--settings", settings(form), "--seed", seed,
         "--output", where / f"{name}.nc", "--gate", where / f"{name}.gate.json")  # fmt: skip
    return json.loads((where / f"{name}.gate.json").read_text())


def predicted(folder, results, jobs=1, form="linear", seed=1):
    """predict/runs.csv and coverage.json of so many jobs, as text."""
    parts = [results / f"{jobs}_{job}.csv" for job in range(jobs)]
    for job, part in enumerate(parts):
        call(predict, "--campaign", folder, "--results", results, "--settings", settings(form), "--seed", seed,
             "--job", job, "--jobs", jobs, "--output", part)  # fmt: skip
    call(predictions, "--output", results / "predicted.csv", "--coverage", results / "coverage.json", *parts)
    return (results / "predicted.csv").read_text(), (results / "coverage.json").read_text()


def test_from_nothing_but_logs_to_predictions(campaign):
    folder, results = campaign
    for name in ("dielectric", "load_cell", "contact"):
        gate = stage(name, folder, results)
        assert gate["source"] == "prior" and gate["converged"] is None and gate["notes"]
    gate = stage("force", folder, results)
    assert gate["source"] == "data" and gate["converged"] is False and gate["failures"]
    assert not list((results / "posterior").glob("*.checkpoint.npz"))
    files = sorted((results / "posterior").glob("*.nc"))
    summary, sensitivity = results / "summary.json", results / "sensitivity.json"
    call(posterior_summary, "--output", summary, "--sensitivity", sensitivity, *files)
    jsonschema.validate(json.loads(summary.read_text()), load_schema("summary"))
    jsonschema.validate(json.loads(sensitivity.read_text()), load_schema("sensitivity"))
    once = predicted(folder, results)
    assert predicted(folder, results) == once
    jsonschema.validate(json.loads(once[1]), load_schema("coverage"))
    table = pd.read_csv(results / "predicted.csv")
    assert list(table.columns) == [
        "run",
        "observable",
        "q05",
        "median",
        "q95",
        "measured",
        "measured_sd",
        "status",
        "held_out",
    ]
    assert set(table["held_out"]) == {True, False} and set(table["observable"]) >= {
        "shear_capacity_n",
        "release_time_90_s",
    }
    shown = table.dropna(subset=["q05", "q95"])
    assert (shown["q05"] <= shown["median"]).all() and (shown["median"] <= shown["q95"]).all()
    capacity = shown[(shown["observable"] == "shear_capacity_n") & ~shown["held_out"]]
    inside = (capacity["measured"] >= capacity["q05"]) & (capacity["measured"] <= capacity["q95"])
    assert inside.mean() > 0.7


def test_a_multiplier_for_every_voltage(campaign):
    folder, results = campaign
    assert stage("force", folder, results, form="per_voltage")["source"] == "data"
    draws = storage.load(results / "posterior" / "force.nc").draws
    assert {n for n in draws if n.startswith("force_multiplier")} == {
        "force_multiplier_200v", "force_multiplier_300v"
    }  # fmt: skip
    predicted(folder, results, form="per_voltage")
    table = pd.read_csv(results / "predicted.csv")
    capacity = table[table["observable"] == "shear_capacity_n"]
    width = (capacity["q95"] - capacity["q05"]).groupby(capacity["held_out"]).mean()
    # a condition that is left out takes its voltage along, whose multiplier then rests on its prior
    assert width[True] > 1.5 * width[False]


def test_predictions_do_not_depend_on_how_many_jobs_make_them(campaign, monkeypatch):
    """Sixteen runs in blocks of three: one job, four, and more jobs than blocks."""
    monkeypatch.setattr(predict_campaign, "TOGETHER", 3)
    folder, results = campaign
    once = predicted(folder, results)
    assert len(pd.read_csv(results / "predicted.csv")["run"].unique()) == 16
    assert predicted(folder, results, jobs=4) == once
    assert predicted(folder, results, jobs=9) == once
    beyond = [
        "--campaign",
        folder,
        "--results",
        results,
        "--job",
        2,
        "--jobs",
        2,
        "--output",
        results / "no.csv",
    ]
    refused = CliRunner().invoke(predict, [str(a) for a in beyond])
    assert isinstance(refused.exception, InputError) and "0 to 1" in str(refused.exception)
