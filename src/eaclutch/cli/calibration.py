"""Commands that check the posteriors: simulation-based calibration, agreement with another sampler, other choices."""

from __future__ import annotations

import json
import logging
from pathlib import Path
from typing import Any

import click
import numpy as np

from eaclutch.cli.inference import stage_inputs
from eaclutch.files import read_json, write_json
from eaclutch.inference.agreement import agreement
from eaclutch.inference.calibration import replications, verdict
from eaclutch.inference.posterior import sampler_settings, stage_problem
from eaclutch.inference.problem import STAGES
from eaclutch.inference.replicable import replicable
from eaclutch.inference.sampling import SamplerSettings
from eaclutch.records import InputError

_FOLDER = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)
# Enough for a rank among 99 draws; a replication costs seconds this way.
QUICK = SamplerSettings(ensembles=2, walkers=20, check_every=400, max_steps=800)


def _common(command: Any) -> Any:
    for option in (
        click.option("--output", type=_FILE, required=True, help="File to write (json)."),
        click.option("--seed", type=int, default=1, show_default=True, help="Seed of the study."),
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
    inputs = stage_inputs(stage, campaign, results, json.loads(settings))
    case = replicable(stage, inputs, np.random.default_rng([seed, 7]))
    found = replications(case, QUICK, seed, range(part, count, parts))
    write_json(output, found)


@click.command("sbc-summary")
@click.argument("files", nargs=-1, required=True, type=_FILE)
@click.option("--seed", type=int, default=1, show_default=True, help="Seed of the simultaneous limit.")
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
    chosen = json.loads(settings)
    problem = stage_problem(
        stage, stage_inputs(stage, campaign, results, chosen), np.random.default_rng([seed, 7])
    )
    if not problem.has_data:
        raise InputError(f"stage {stage}", "rests on its prior", "there is nothing to compare")
    found = agreement(problem, sampler_settings(chosen["posterior"]), seed)
    logging.info("agreement %s: %s", stage, "passed" if found["passed"] else "the samplers differ")
    write_json(output, found)


COMMANDS = [sbc, sbc_summary, agreement_of]
