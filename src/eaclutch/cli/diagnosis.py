"""Commands of the diagnosis room: is there a gap, weigh a candidate, say the verdict."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from eaclutch.config import load_bench
from eaclutch.config.slices import parse_settings
from eaclutch.diagnosis.conclude import CAMPAIGNS, conclude, gap_summary
from eaclutch.diagnosis.files import read_inputs
from eaclutch.diagnosis.forecast import Forecast
from eaclutch.diagnosis.pairs import with_pairs
from eaclutch.diagnosis.planned import planned_study
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.files import read_json, write_json
from eaclutch.records import InputError
from eaclutch.rig.campaign import open_campaign

_FOLDER = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)


def common(command: Any) -> Any:
    """The options that every command of this room takes."""
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


_GAP = click.option("--gap", type=_FILE, help="gap.json of these results: its fits are not done again.")


def study_of(campaign: Path, results: Path, settings: str, seed: int, gap: Path | None = None) -> Study:
    """The study that a command's common options, and ``--gap``, ask for."""
    chosen = parse_settings(settings)
    known = read_json(gap) if gap else None
    return Study(read_inputs(results, load_bench(campaign), chosen), load_thresholds(), seed, known)


@click.command("diagnosis-gap")
@common
def diagnosis_gap(output: Path, **options: Any) -> None:
    """Is there a gap beyond repeatability? The base model's fit (gap.json)."""
    study = study_of(**options)
    for value in study.data.odd:
        logging.info("left out, far from all repeats: %s", value)
    base = study.weigh(())
    summary = gap_summary(study, base)
    write_json(output, {"schema": 1, "summary": summary, "base": base.document(), **study.fits})


def refuse_others(study: Study, effects: Sequence[str]) -> None:
    """Raise InputError unless ``effects`` are one or two of those that ``study`` may weigh."""
    known = (*study.candidates, *study.lookalikes)
    for name in effects:
        if name not in known:
            raise InputError(
                f"candidate {name}", "is none that this model lacks", f"choose of {', '.join(known)}"
            )
    if len(effects) > 2 or len(set(effects)) < len(effects):
        raise InputError(
            f"candidates {' '.join(effects)}", "are not one or two", "name one, or two that differ"
        )


@click.command("diagnosis-candidate")
@click.argument("effects", nargs=-1, required=True)
@_GAP
@common
def diagnosis_candidate(effects: tuple[str, ...], output: Path, **options: Any) -> None:
    """Weigh one candidate (or two together) jointly with the calibrated parameters."""
    study = study_of(**options)
    refuse_others(study, effects)
    write_json(output, study.weigh(tuple(sorted(effects))).document())


@click.command("diagnosis")
@click.argument("candidates", nargs=-1, type=_FILE)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="Processes that pairs are weighed in.",
)
@_GAP
@common
def diagnosis(candidates: tuple[Path, ...], jobs: int, output: Path, settings: str, **options: Any) -> None:
    """The verdict from all weighed CANDIDATES (diagnosis.json)."""
    study = study_of(settings=settings, **options)
    found = [study.weigh(()), *read_weighed(candidates, study)]
    chosen = parse_settings(settings).get("diagnosis", {})
    weighed = with_pairs(study, found, chosen.get("pairs", 6), jobs)
    write_json(output, conclude(study, weighed, chosen.get("null_campaigns", CAMPAIGNS)))


def read_weighed(paths: Sequence[Path], study: Study) -> list[CandidateResult]:
    """Weighed candidates. Raises InputError for a set of effects that comes twice, or one of the lookalikes."""
    found: dict[tuple[str, ...], CandidateResult] = {}
    for path in paths:
        result = CandidateResult.read(read_json(path))
        if set(result.effects) & set(study.lookalikes):
            raise InputError(path, "weighs a lookalike, which the verdict weighs by itself", "leave it out")
        if result.effects in found:
            raise InputError(path, "weighs what another file does", "give a file for each set of effects")
        found[result.effects] = result
    return list(found.values())


@click.command("confusion")
@common
def confusion(campaign: Path, results: Path, settings: str, seed: int, output: Path) -> None:
    """What this campaign's design could tell apart, before its data are looked at (confusion.json)."""
    chosen = parse_settings(settings)
    study = planned_study(open_campaign(campaign), chosen, load_thresholds(), seed)
    write_json(output, Forecast(study).document(study.generator(21)))


COMMANDS = [diagnosis_gap, diagnosis_candidate, diagnosis, confusion]
