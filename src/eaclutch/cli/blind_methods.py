"""How a sealed case is diagnosed: the library's own diagnosis, with or without one of its effects."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd

from eaclutch.config import load_bench
from eaclutch.diagnosis.closure import surely_left
from eaclutch.diagnosis.conclude import conclude
from eaclutch.diagnosis.files import bursts as bursts_table
from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.diagnosis.nameless import nameless_fit
from eaclutch.diagnosis.pairs import with_pairs
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import UNKNOWN, probabilities
from eaclutch.files import read_table
from eaclutch.physics.effects import BASE, CANDIDATES
from eaclutch.records import BurstFeatures, Campaign, InputError
from eaclutch.rig.batch import extract_batch, join_batches
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.capacitance import read_capacitance
from eaclutch.rig.load_cell import read_bursts
from eaclutch.rig.spectra import read_spectra

COMMANDS: list[click.Command] = []
LEAVE_OUT = "without-"


def diagnose_case(
    folder: Path, method: str, settings: Mapping[str, Any], seed: int
) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any], float]:
    """Diagnose one campaign folder.

    Returns diagnosis.json, what is kept beside it (calibrated parameters before and after; what would have been
    said without each candidate), the fits for comparators (``Fits``), and seconds.

    ``method``: ``library``, or ``without-<effect>`` to take a candidate out of the library.
    """
    start = time.monotonic()
    inputs = read_case(folder, method, settings)
    study = Study(inputs, load_thresholds(), seed)
    found = [study.weigh(())] + [study.weigh((name,)) for name in study.candidates]
    pairs = settings.get("diagnosis", {}).get("pairs", 6)
    found = with_pairs(study, found, pairs)
    document = conclude(study, found)
    named = tuple(document["verdict"]["effects"])
    after = next((result for result in found if set(result.effects) == set(named)), found[0])
    document_without = _without(study, found)
    parameters = {"before": study.constants(found[0]), "after": study.constants(after)}
    sides = {"parameters": parameters, "without": document_without}
    named_fits = [result for result in found if not set(result.effects) & set(study.lookalikes)]
    return document, sides, _fits(study, named_fits), time.monotonic() - start


def _without(study: Study, found: Sequence[CandidateResult]) -> dict[str, Any]:
    """Verdicts with each candidate taken out of the library in turn; the other fits stay as they are."""
    out = {}
    left = surely_left(study, found)
    for name in study.candidates:
        kept = [result for result in found if name not in result.effects]
        weights = probabilities(kept, study.thresholds, left)
        verdict = decide(weights, kept, study.thresholds, [])
        out[name] = {"effects": list(verdict.effects), "unknown": weights.get(UNKNOWN, 0.0)}
    return out


def _fits(study: Study, found: Sequence[CandidateResult]) -> dict[str, Any]:
    """Plain numbers of all fits (``eaclutch.blind.comparators.Fits``)."""
    count = study.data.run_entries
    sd = np.sqrt(study.cells.variance)
    rest = nameless_fit(study.base.linearised, study.data, study.kernels, study.thresholds)
    return {
        "effects": [list(result.effects) for result in found],
        "errors": [study.cells.errors(np.array(result.errors)[:count]) / sd for result in found],
        "left_out": [study.cells.errors(np.array(result.errors_left_out)[:count]) / sd for result in found],
        "log_density": [result.log_density for result in found],
        "sizes": [len(result.parameters) for result in found],
        "nameless_gain": rest.log_evidence - found[0].log_evidence,
    }


def read_case(folder: Path, method: str, settings: Mapping[str, Any]) -> DiagnosisInputs:
    """What a diagnosis starts from: from raw logs where the folder has them, else from its runs.csv."""
    bench = load_bench(folder)
    if (folder / "tensile").is_dir():
        campaign = open_campaign(folder)
        batch = extract_batch([log.path for log in campaign.logs], bench)
        table, _ = join_batches([pd.DataFrame(batch.runs)], bench)
        swings: BurstFeatures | None = read_bursts(campaign)
    elif (folder / "runs.csv").is_file():
        files = {
            kind: tuple(sorted((folder / kind).glob("*.csv"))) for kind in ("capacitance", "permittivity")
        }
        campaign = Campaign(folder, bench, (), files["capacitance"], files["permittivity"], ())
        table = read_table(folder / "runs.csv")
        swings = bursts_table(folder / "bursts.csv")
    else:
        raise InputError(folder, "holds neither logs nor runs.csv", "seal the case again")
    return DiagnosisInputs(
        bench=bench,
        table=table,
        readings=read_capacitance(campaign),
        spectra=read_spectra(campaign),
        bursts=swings,
        effects=tuple(BASE),
        candidates=_candidates(method, settings),
        priors=settings.get("priors") or {},
    )


def _candidates(method: str, settings: Mapping[str, Any]) -> tuple[str, ...]:
    chosen = tuple(settings.get("diagnosis", {}).get("candidates") or ())
    chosen = chosen or CANDIDATES
    if method.startswith(LEAVE_OUT):
        out = method.removeprefix(LEAVE_OUT)
        if out not in chosen:
            raise InputError(f"method {method}", f"{out} is no candidate", f"take one of {', '.join(chosen)}")
        return tuple(name for name in chosen if name != out)
    if method != "library":
        raise InputError(f"method {method}", "is not known", "take library or without-<effect>")
    return chosen
