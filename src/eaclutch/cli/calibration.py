"""Commands that check the posteriors: simulation-based calibration, agreement with another sampler, other choices."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import click
import numpy as np

from eaclutch.cli.inference import stage_inputs
from eaclutch.config.slices import parse_settings
from eaclutch.files import read_json, write_csv, write_json
from eaclutch.inference import storage
from eaclutch.inference.agreement import agreement
from eaclutch.inference.calibration import replications, verdict
from eaclutch.inference.choices import Replicates, contact_rows, dielectric_rows, multiplier_rows, table
from eaclutch.inference.draws import spread_out
from eaclutch.inference.posterior import StageInputs, sampler_settings, stage_problem
from eaclutch.inference.problem import STAGES
from eaclutch.inference.replicable import replicable
from eaclutch.inference.sampling import SamplerSettings
from eaclutch.physics.model import ClutchModel
from eaclutch.records import InputError

_FOLDER = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)
# Enough for a rank among 99 draws; a replication costs seconds this way.
QUICK = SamplerSettings(ensembles=2, walkers=20, check_every=400, max_steps=400, warm_up=200)


def _common(command: Any) -> Any:
    for option in (
        click.option("--output", type=_FILE, required=True, help="File to write (json)."),
        click.option(
            "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of the study."
        ),
        click.option("--settings", default="{}", help="Config sections posterior, priors and model as JSON."),
        click.option("--results", type=_FOLDER, required=True, help="The campaign's results folder."),
        click.option(
            "--campaign", type=_FOLDER, required=True, help="The campaign's folder: its data's layout."
        ),
    ):
        command = option(command)
    return command


@click.command("sbc")
@click.argument("stage", type=click.Choice(STAGES))
@_common
@click.option(
    "--replications", "count", type=int, default=200, show_default=True, help="Replications in all."
)
@click.option("--part", type=int, default=0, show_default=True, help="Which part of them.")
@click.option("--parts", type=int, default=1, show_default=True, help="Into how many parts they are split.")
def sbc(
    stage: str,
    campaign: Path,
    results: Path,
    settings: str,
    seed: int,
    output: Path,
    count: int,
    part: int,
    parts: int,
) -> None:
    """Ranks of true values in a STAGE's posteriors of data made from its prior and likelihood."""
    inputs = stage_inputs(stage, campaign, results, parse_settings(settings))
    case = replicable(stage, inputs, np.random.default_rng([seed, 7]))
    found = replications(case, QUICK, seed, range(part, count, parts))
    write_json(output, found)


@click.command("sbc-summary")
@click.argument("files", nargs=-1, required=True, type=_FILE)
@click.option(
    "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of the simultaneous limit."
)
@click.option("--output", type=_FILE, required=True, help="Verdicts by stage to write (json).")
def sbc_summary(files: tuple[Path, ...], seed: int, output: Path) -> None:
    """Join parts of a calibration study: are ranks uniform, do 90 % intervals cover 90 %?"""
    joined: dict[str, dict[str, list[int]]] = {}
    for path in files:
        part = read_json(path)
        ranks = joined.setdefault(part["stage"], {name: [] for name in part["ranks"]})
        for name, values in part["ranks"].items():
            ranks[name] += values
    document = {stage: verdict(ranks, np.random.default_rng(seed)) for stage, ranks in sorted(joined.items())}
    for stage, found in document.items():
        logging.info("sbc %s: %s", stage, "passed" if found["passed"] else "ranks are not uniform")
    write_json(output, document)


@click.command("agreement")
@click.argument("stage", type=click.Choice(STAGES))
@_common
def agreement_of(stage: str, campaign: Path, results: Path, settings: str, seed: int, output: Path) -> None:
    """A STAGE's posterior by emcee and by nested sampling: means within 0.1 sd, sds within 10 %."""
    chosen = parse_settings(settings)
    problem = stage_problem(
        stage, stage_inputs(stage, campaign, results, chosen), np.random.default_rng([seed, 7])
    )
    if not problem.has_data:
        raise InputError(f"stage {stage}", "rests on its prior", "there is nothing to compare")
    found = agreement(problem, sampler_settings(chosen["posterior"]), seed)
    logging.info("agreement %s: %s", stage, "passed" if found["passed"] else "the samplers differ")
    write_json(output, found)


@click.command("published-fits")
@_common
@click.option(
    "--replicates", type=int, default=60, show_default=True, help="Replicated data sets a fit is tried on."
)
def published_fits(
    campaign: Path, results: Path, settings: str, seed: int, output: Path, replicates: int
) -> None:
    """The paper's point fits by its own choices and by others, beside our posterior (csv)."""
    chosen, rng, rows = parse_settings(settings), np.random.default_rng([seed, 3]), []
    inputs = {stage: stage_inputs(stage, campaign, results, chosen) for stage in STAGES}
    made = {
        stage: _replicates(stage, inputs[stage], results, seed, replicates)
        for stage in ("contact", "dielectric")
    }
    readings, spectra, data = (
        inputs["contact"].readings,
        inputs["dielectric"].spectra,
        inputs["force"].capacity,
    )
    if readings is not None:
        rows += contact_rows(readings, inputs["contact"].bench, made["contact"], rng)
    if len(spectra):
        rows += dielectric_rows(spectra, made["dielectric"], rng)
    if data is not None:
        arguments = dict(inputs["force"].model or {})
        model = ClutchModel(inputs["force"].bench, **arguments, force_multiplier_form="constant")
        path = results / "posterior" / "force.nc"
        draws = storage.load(path).draws if path.is_file() else {}
        rows += multiplier_rows(model, data, _point_choices(rows), draws)
    write_csv(output, table(rows))


def _point_choices(rows: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """Point values of contact and dielectric parameters, by choice."""
    point: dict[str, dict[str, float]] = {}
    for row in rows:
        point.setdefault(row["choice"], {})[row["quantity"]] = row["value"]
    contact = {c: v for c, v in point.items() if "contact_stiffness" in v}
    dielectric = {c: v for c, v in point.items() if "kappa_static" in v}
    first = next(iter(dielectric.values()), {})
    choices = {c: v | first | {"kappa_infinity": 4.0} for c, v in contact.items()}
    if contact:
        known = next(iter(contact.values()))
        choices |= {c: known | v | {"kappa_infinity": 4.0} for c, v in dielectric.items() if "alone" not in c}
    return choices


def _replicates(stage: str, inputs: StageInputs, results: Path, seed: int, count: int) -> Replicates | None:
    path = results / "posterior" / f"{stage}.nc"
    problem = stage_problem(stage, inputs, np.random.default_rng([seed, 7]))
    if not problem.has_data or not path.is_file():
        return None
    draws = spread_out(storage.load(path).draws, count, 0)
    return Replicates(problem, np.stack([draws[name] for name in problem.priors.names], axis=1))


COMMANDS = [sbc, sbc_summary, agreement_of, published_fits]
