"""Commands of the inference room: a stage's posterior, the table of all stages, predictions of every run."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd

from eaclutch.config import load_bench
from eaclutch.config.slices import parse_settings
from eaclutch.files import read_table, write_csv, write_json
from eaclutch.inference import storage
from eaclutch.inference.parameters import with_priors
from eaclutch.inference.posterior import (
    StageInputs,
    gate,
    run_stage,
    sampler_settings,
    stage_problem,
    with_code,
)
from eaclutch.inference.predict_campaign import curves_of, predict_campaign, ranks_of, shown
from eaclutch.inference.prediction import GIVEN, Measured
from eaclutch.inference.problem import STAGES
from eaclutch.inference.stages.contact import ContactSettings
from eaclutch.inference.stages.force import CapacityData
from eaclutch.inference.summary import sensitivities, summarise
from eaclutch.physics.effect import Parameter
from eaclutch.physics.effects import switched_on
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import OBSERVABLES
from eaclutch.provenance import code_hash
from eaclutch.records import Bench, BurstFeatures, InputError
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.capacitance import read_capacitance
from eaclutch.rig.spectra import read_spectra
from eaclutch.rig.table import conditions_from_runs

_FOLDER = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)


def _common(command: Any) -> Any:
    for option in (
        click.option(
            "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of the sampler."
        ),
        click.option(
            "--settings", default="{}", help="Config sections as JSON: posterior, priors, model, predict."
        ),
        click.option("--results", type=_FOLDER, required=True, help="The campaign's results folder."),
        click.option("--campaign", type=_FOLDER, required=True, help="The campaign's folder."),
    ):
        command = option(command)
    return command


def model_arguments(model: dict[str, Any]) -> dict[str, Any]:
    """Arguments of ClutchModel from the config's ``model`` section, without the multiplier's form."""
    return {
        "effects": switched_on(model),
        "roughness_rule": model.get("roughness_rule", "published"),
        "roughness_cut": model.get("roughness_cut", 0.83),
    }


def _bursts(results: Path) -> BurstFeatures:
    table = pd.read_csv(results / "bursts.csv", dtype=float)
    names = ("frequency_hz", "frequency_hz_sd", "damping_ratio", "damping_ratio_sd")
    return BurstFeatures(*(table[name].to_numpy(float) for name in names))


def capacity_data(runs: pd.DataFrame, bench: Bench) -> CapacityData | None:
    """Usable runs with voltage and a shear capacity, thinned where there are very many."""
    good = runs["shear_capacity_n"].gt(0) & runs["shear_capacity_n_sd"].notna() & runs["voltage_v"].gt(0)
    conditions = conditions_from_runs(runs[good], bench)
    picked = runs.set_index("run").loc[list(conditions.run)]
    if not len(picked):
        return None
    return CapacityData(
        conditions, picked["shear_capacity_n"].to_numpy(float), picked["shear_capacity_n_sd"].to_numpy(float)
    ).thinned()


def stage_inputs(stage: str, campaign: Path, results: Path, chosen: Mapping[str, Any]) -> StageInputs:
    """What a stage rests on: campaign, earlier stages' files in ``results``, config sections."""
    config, model = chosen["posterior"], chosen.get("model", {})
    opened = open_campaign(campaign)
    arguments = model_arguments(model)
    known = ClutchModel(opened.bench, **arguments, force_multiplier_form="linear").parameters
    inputs = StageInputs(opened.bench, with_priors(known, chosen.get("priors", {})), model=arguments)
    files = [results / "posterior" / f"{name}.nc" for name in _earlier(stage)]
    inputs = replace(inputs, earlier=[path for path in files if path.is_file()])
    if stage == "dielectric":
        return replace(inputs, spectra=read_spectra(opened), spectra_weights=config["spectra_weights"])
    if stage == "load_cell":
        return replace(inputs, bursts=_bursts(results))
    if stage == "contact":
        readings = read_capacitance(opened)
        contact = ContactSettings(
            force_sd=config["capacitance_force_sd_n"], force_max=config["capacitance_force_max_n"],
            widths=tuple(w * 1e-3 for w in config["capacitance_widths_mm"]),
            stray_sd=max(config["stray_capacitance_sd_pf"] * 1e-12, _stray_of_effect(known)),
        )  # fmt: skip
        return replace(inputs, readings=readings if len(readings.force) else None, contact=contact)
    form = model.get("force_multiplier_form", "linear")
    return replace(
        inputs, capacity=capacity_data(read_table(results / "runs.csv"), opened.bench), multiplier_form=form
    )


def _stray_of_effect(known: Mapping[str, Parameter]) -> float:
    """Prior scale [F] of the stray capacitance where the model has the effect of that name, else 0."""
    parameter = known.get("stray_capacitance.capacitance")
    return 0.0 if parameter is None else parameter.prior.a


def _earlier(stage: str) -> tuple[str, ...]:
    return {"contact": ("dielectric",), "force": ("dielectric", "load_cell", "contact")}.get(stage, ())


@click.command("posterior")
@click.argument("stage", type=click.Choice(STAGES))
@_common
@click.option("--output", type=_FILE, required=True, help="InferenceData file to write.")
@click.option("--gate", "gate_file", type=_FILE, required=True, help="Gate file to write.")
def posterior(
    stage: str, campaign: Path, results: Path, settings: str, seed: int, output: Path, gate_file: Path
) -> None:
    """Sample a STAGE of the posterior (.nc) and say whether it converged (.gate.json)."""
    chosen = parse_settings(settings)
    inputs = stage_inputs(stage, campaign, results, chosen)
    problem = stage_problem(stage, inputs, np.random.default_rng([seed, 7]))
    problem = with_code(problem, code_hash(["inference.posterior"], (inputs.model or {}).get("effects", ())))
    for note in problem.notes:
        logging.info("%s: %s", stage, note)
    sampler = sampler_settings(chosen["posterior"])
    checkpoint = output.with_suffix(".checkpoint.npz")
    data, sampled = run_stage(problem, sampler, seed, checkpoint)
    storage.save(output, data)
    write_json(gate_file, gate(problem, sampler, sampled, data))
    checkpoint.unlink(missing_ok=True)


@click.command("posterior-summary")
@click.argument("files", nargs=-1, required=True, type=_FILE)
@click.option("--output", type=_FILE, required=True, help="summary.json to write.")
@click.option("--sensitivity", type=_FILE, help="Prior sensitivities and conflicts to write (json).")
def posterior_summary(files: tuple[Path, ...], output: Path, sensitivity: Path | None) -> None:
    """Means, quantiles and diagnostics of all stages (summary.json) from their FILES."""
    write_json(output, summarise(files))
    if sensitivity is not None:
        write_json(sensitivity, sensitivities(files))


@click.command("predict")
@_common
@click.option("--output", type=_FILE, required=True, help="Predictions of the job's runs to write (csv).")
@click.option("--job", type=click.IntRange(min=0), default=0, show_default=True, help="Number of the job.")
@click.option("--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="How many there are.")
def predict(
    campaign: Path, results: Path, settings: str, seed: int, output: Path, job: int, jobs: int
) -> None:
    """Predict a job's share of the runs from joint posterior draws, in the sample and left out."""
    if job >= jobs:
        raise InputError(f"--job {job}", f"is none of {jobs}", f"give 0 to {jobs - 1}")
    chosen = parse_settings(settings)
    bench = load_bench(campaign)
    runs = read_table(results / "runs.csv")
    model = chosen.get("model", {})
    arguments, form = model_arguments(model), model.get("force_multiplier_form", "linear")
    files = [path for stage in STAGES if (path := results / "posterior" / f"{stage}.nc").is_file()]
    clutch = ClutchModel(
        bench, **arguments, force_multiplier_form="constant" if form == "per_voltage" else form
    )
    inputs = StageInputs(
        bench, with_priors(clutch.parameters, chosen.get("priors", {})), capacity=capacity_data(runs, bench),
        multiplier_form=form, model=arguments, earlier=files,
    )  # fmt: skip
    draws = chosen.get("predict.draws", 200)
    parts = chosen.get("predict.folds", 5)
    measured = measured_runs(runs, bench)
    write_csv(
        output,
        predict_campaign(clutch, inputs, measured, seed=seed, draws=draws, parts=parts, job=(job, jobs)),
    )


@click.command("predictions")
@click.argument("parts", nargs=-1, required=True, type=_FILE)
@click.option("--output", type=_FILE, required=True, help="Predictions of every run to write (csv).")
@click.option("--coverage", type=_FILE, required=True, help="Calibration curves to write (json).")
def predictions(parts: tuple[Path, ...], output: Path, coverage: Path) -> None:
    """One table of all jobs' predictions, given in the order of the jobs, and their calibration curves."""
    # read twice: no more than one part is ever in memory
    write_csv(output, (shown(read_table(path)) for path in parts))
    write_json(coverage, curves_of(ranks_of(read_table(path) for path in parts)))


def measured_runs(runs: pd.DataFrame, bench: Bench) -> Measured:
    """Usable runs with voltage and their observables."""
    conditions = conditions_from_runs(runs[runs["voltage_v"].gt(0)], bench)
    picked = runs.set_index("run").loc[list(conditions.run)]
    names = [name for name in OBSERVABLES if name in picked and name not in GIVEN]
    return Measured(
        conditions,
        {name: picked[name].to_numpy(float) for name in names},
        {name: picked[f"{name}_sd"].to_numpy(float) for name in names},
        picked["preload_n"].to_numpy(float),
    )


COMMANDS = [posterior, posterior_summary, predict, predictions]
