"""The diagnosis' finalists, sampled in full: a command of its own, for no other one needs the sampler."""

from __future__ import annotations

import logging
from pathlib import Path

import click

from eaclutch.cli.diagnosis import common, study_of
from eaclutch.config.slices import parse_settings
from eaclutch.diagnosis.full import compared, document, finalists, fit_of, problem_of
from eaclutch.files import read_json, write_json
from eaclutch.inference import storage
from eaclutch.inference.posterior import sampler_settings, with_code
from eaclutch.inference.sampling import sample
from eaclutch.provenance import code_hash

_FOLDER = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)
logger = logging.getLogger(__name__)


@click.command("diagnosis-full")
@click.option("--diagnosis", "verdict", type=_FILE, required=True, help="diagnosis.json.")
@click.option("--draws", type=_FOLDER, required=True, help="Folder for each finalist's draws (.nc).")
@common
def diagnosis_full(
    verdict: Path, draws: Path, campaign: Path, results: Path, settings: str, seed: int, output: Path
) -> None:
    """Sample the finalists in full and compare with Laplace (full.json)."""
    study, told = study_of(campaign, results, settings, seed), read_json(verdict)
    sampler = sampler_settings(parse_settings(settings)["posterior"])
    draws.mkdir(parents=True, exist_ok=True)
    rows, checkpoints = [], []
    for number, effects in enumerate(finalists(told)):
        name = "+".join(effects) or "base"
        checkpoints.append(output.with_suffix(f".{name}.checkpoint.npz"))
        fitted = fit_of(study, effects, told)
        code = code_hash(["diagnosis.full"], (*study.inputs.effects, *effects))
        problem = with_code(problem_of(study, fitted), code)
        logger.info("diagnosis: %s, %d parameters", name, len(problem.priors))
        sampled = sample(
            problem, sampler, seed + number,
            checkpoint=checkpoints[-1], progress=logger.info, begin=fitted.mode.u,
        )  # fmt: skip
        storage.save(draws / f"{name}.nc", storage.inference_data(problem, sampler, seed, sampled))
        rows.append(compared(study, fitted, sampled, study.generator(31, number)))
    write_json(output, document(rows, told, float(study.thresholds["temperature"])))
    for checkpoint in checkpoints:  # only now: a killed run goes on behind its last finished finalist
        checkpoint.unlink(missing_ok=True)


COMMANDS = [diagnosis_full]
