"""Commands of the diagnosis room: is there a gap, weigh a candidate, say the verdict."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import click

from eaclutch.config import load_bench
from eaclutch.config.slices import parse_settings
from eaclutch.diagnosis.conclude import conclude, gap_summary
from eaclutch.diagnosis.files import read_inputs
from eaclutch.diagnosis.forecast import Forecast
from eaclutch.diagnosis.full import compared, document, finalists, fit_of, problem_of
from eaclutch.diagnosis.pairs import with_pairs
from eaclutch.diagnosis.planned import planned_study
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.files import read_json, write_json
from eaclutch.inference import storage
from eaclutch.inference.posterior import sampler_settings, with_code
from eaclutch.inference.sampling import sample
from eaclutch.provenance import code_hash
from eaclutch.rig.campaign import open_campaign

_FOLDER = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)
logger = logging.getLogger(__name__)


def _common(command: Any) -> Any:
    for option in (
        click.option("--output", type=_FILE, required=True, help="File to write."),
        click.option(
            "--seed",
            type=click.IntRange(min=0),
            default=1,
            show_default=True,
            help="Seed of simulated campaigns.",
        ),
        click.option("--settings", default="{}", help="Config sections model, priors and diagnosis as JSON."),
        click.option("--results", type=_FOLDER, required=True, help="The campaign's results folder."),
        click.option("--campaign", type=_FOLDER, required=True, help="The campaign's folder."),
    ):
        command = option(command)
    return command


_GAP = click.option("--gap", type=_FILE, help="gap.json of these results: its first fit is not done again.")


def _study(campaign: Path, results: Path, settings: str, seed: int, gap: Path | None = None) -> Study:
    """The study that a command's common options, and ``--gap``, ask for."""
    chosen = parse_settings(settings)
    first_fit = read_json(gap)["first_fit"] if gap else None
    return Study(read_inputs(results, load_bench(campaign), chosen), load_thresholds(), seed, first_fit)


@click.command("diagnosis-gap")
@_common
def diagnosis_gap(output: Path, **options: Any) -> None:
    """Is there a gap beyond repeatability? The base model's fit (gap.json)."""
    study = _study(**options)
    base = study.weigh(())
    summary = gap_summary(study, base)
    write_json(
        output,
        {"schema": 1, "summary": summary, "base": base.document(), "first_fit": study.first_fit},
    )


@click.command("diagnosis-candidate")
@click.argument("effects", nargs=-1, required=True)
@_GAP
@_common
def diagnosis_candidate(effects: tuple[str, ...], output: Path, **options: Any) -> None:
    """Weigh one candidate (or two together) jointly with the calibrated parameters."""
    write_json(output, _study(**options).weigh(effects).document())


@click.command("diagnosis")
@click.argument("candidates", nargs=-1, type=_FILE)
@_GAP
@_common
def diagnosis(candidates: tuple[Path, ...], output: Path, settings: str, **options: Any) -> None:
    """The verdict from all weighed CANDIDATES (diagnosis.json)."""
    study = _study(settings=settings, **options)
    found = [study.weigh(())] + [CandidateResult.read(read_json(path)) for path in candidates]
    pairs = parse_settings(settings).get("diagnosis", {}).get("pairs", 6)
    write_json(output, conclude(study, with_pairs(study, found, pairs)))


@click.command("confusion")
@_common
def confusion(campaign: Path, results: Path, settings: str, seed: int, output: Path) -> None:
    """What this campaign's design could tell apart, before its data are looked at (confusion.json)."""
    chosen = parse_settings(settings)
    study = planned_study(open_campaign(campaign), chosen, load_thresholds(), seed)
    write_json(output, Forecast(study).document(study.generator(21)))


@click.command("diagnosis-full")
@click.option("--diagnosis", "verdict", type=_FILE, required=True, help="diagnosis.json.")
@click.option("--draws", type=_FOLDER, required=True, help="Folder for each finalist's draws (.nc).")
@_common
def diagnosis_full(
    verdict: Path, draws: Path, campaign: Path, results: Path, settings: str, seed: int, output: Path
) -> None:
    """Sample the finalists in full and compare with Laplace (full.json)."""
    study, told = _study(campaign, results, settings, seed), read_json(verdict)
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


COMMANDS = [diagnosis_gap, diagnosis_candidate, diagnosis, diagnosis_full, confusion]
