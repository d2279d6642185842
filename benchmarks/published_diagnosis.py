"""Does the diagnosis hold on real recordings? Known effects withheld, sessions left out, levels left out.

    python benchmarks/published_diagnosis.py --campaign ../shared/published --results results/published --record

prints a table and records docs/measurements/published_checks.json. ``--results`` is the folder that the published
config's run has filled. What each check has fitted is kept in ``--work`` as soon as it is done, with the commit that
fitted it: an interrupted call goes on, and another rule for the verdict needs no fits. ``--only withheld`` makes the
checks with that word in their names; the others stay as they were recorded.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from multiprocessing import Pool
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
from measurement import FOLDER, commit, record

from eaclutch.config import load_bench
from eaclutch.diagnosis.conclude import conclude
from eaclutch.diagnosis.files import read_inputs
from eaclutch.diagnosis.gaussian import Linearised, leave_out
from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.diagnosis.pairs import with_pairs
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.files import read_json, write_json

WITHHELD = ("dielectric_relaxation", "load_cell_dynamics", "air_gap", "surface_roughness")
CLOSING = ("series_compliance", "substrate_inertia")  # the full model's verdict
PAIRS = 6
CHANCE = "baseline_shift_n"  # where the tip comes to rest: hardly counts in a fit (thresholds.yaml, scatter)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--campaign", type=Path, required=True)
    parser.add_argument("--results", type=Path, required=True)
    parser.add_argument("--work", type=Path, default=Path("published-checks"))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="a word in the names of the checks that are made")
    parser.add_argument("--record", action="store_true")
    chosen = parser.parse_args()
    inputs = read_inputs(chosen.results, load_bench(chosen.campaign), {})
    checks: dict[str, DiagnosisInputs] = {"full": inputs}
    # what is named goes into the model: what then?
    checks[f"again with {' and '.join(CLOSING)}"] = replace(inputs, effects=(*inputs.effects, *CLOSING))
    for session in sorted(set(inputs.table["session"].astype(str))):
        kept = inputs.table[inputs.table["session"].astype(str) != session]
        checks[f"without session {session}"] = replace(inputs, table=kept.reset_index(drop=True))
    for name in WITHHELD:
        kept_effects = tuple(effect for effect in inputs.effects if effect != name)
        checks[f"withheld {name}"] = replace(inputs, effects=kept_effects)
        # the gap of the full model is large: with what closes most of it in, the withheld effect stands alone
        checks[f"withheld {name} beside {' and '.join(CLOSING)}"] = replace(
            inputs, effects=(*kept_effects, *CLOSING)
        )
    jobs = [(name, case, chosen.work / f"{name.replace(' ', '_')}.json") for name, case in checks.items()]
    jobs = [job for job in jobs if chosen.only in job[0]]
    if not jobs:
        parser.error(f"--only {chosen.only}: no check has that in its name; there are {', '.join(checks)}")
    found: dict[str, dict[str, Any]] = {}
    with Pool(chosen.jobs) as pool:
        for name, done in pool.imap_unordered(checked, jobs):
            verdict = done["verdict"]
            print(name, verdict["effects"], f"{verdict['probability']:.2f}", flush=True)
            found[name] = done
    if "full" in found:
        found["full"]["left_out_levels_together"] = together(found["full"]["left_out_levels"])
    if chosen.record:
        if chosen.only:
            found = read_json(FOLDER / "published_checks.json")["checks"] | found
        command = "python benchmarks/published_diagnosis.py --campaign <published> --results results/published --record"
        record("published_checks", command, {"checks": {name: found[name] for name in checks}})


def checked(job: tuple[str, DiagnosisInputs, Path]) -> tuple[str, dict[str, Any]]:
    """One check's name and result, from the fits that its file keeps; made and kept where there is none."""
    name, inputs, path = job
    if not path.is_file():
        study = Study(inputs, load_thresholds())
        found = [study.weigh(()), *(study.weigh((effect,)) for effect in study.candidates)]
        found = with_pairs(study, found, PAIRS)
        weighed = [result.document() for result in found]
        write_json(path, {"commit": commit(), "study": study.fits, "weighed": weighed})
    kept = read_json(path)
    study = Study(inputs, load_thresholds(), known=kept["study"])
    found = [CandidateResult.read(result) for result in kept["weighed"]]
    return name, {"commit": commit(), "fits_of": kept["commit"], **check(study, found, name == "full")}


def check(study: Study, found: Sequence[CandidateResult], levels: bool) -> dict[str, Any]:
    """Verdict, closure and the leading hypotheses of one variant; ``levels``: predictions of left-out levels too."""
    document = conclude(study, found)
    named = tuple(document["verdict"]["effects"])
    out = {
        "verdict": document["verdict"],
        "closure": document["closure"],
        "hypotheses": document["hypotheses"][:5],
        "parameters": {e["effect"]: e["parameters"] for e in document["causes"] if e["effect"] in named},
        "absorbed": document["absorbed"],
    }
    return out | ({"left_out_levels": left_out_levels(study, out)} if levels else {})


def left_out_levels(study: Study, found: Mapping[str, Any]) -> dict[str, Any]:
    """Each width, thickness and preload bin predicted from the others: mean square error over the repeats' variance,
    by the base model, the verdict of the check ``found``, from where its fit stands, the base model with the nameless
    smooth term carried over, and the verdict with its own tolerance carried over; over all observables, by observable,
    and over all but the one that is nearly chance."""
    base = verdict = study.base.linearised
    named = tuple(name for name in found["parameters"] if name != "unknown")
    if named:
        seeds = {name: float(entry["after"]) for name, entry in found["absorbed"].items()}
        for effect, parameters in found["parameters"].items():
            seeds |= {f"{effect}.{name}": float(entry["mean"]) for name, entry in parameters.items()}
        verdict = study.fit(named, seeds, afresh=study.base.multipliers).linearised
    data, runs = study.data, study.data.run_entries
    first = [int(np.flatnonzero(data.groups == group)[0]) for group in data.entry_group]
    channel = np.asarray(data.channel[:runs]).astype(str)
    bins = np.digitize(study.data.preload[first], (0.25, 0.75, 1.5))
    settings = {
        "width_mm": np.round(1e3 * data.conditions.width[first], 3),
        "thickness_mm": np.round(1e3 * data.conditions.thickness[first], 3),
        "preload_bin": bins,
    }
    out: dict[str, Any] = {}
    for factor, values in settings.items():
        groups = [np.flatnonzero(values == level) for level in np.unique(values)]
        if len(groups) < 2:
            continue
        rows = {
            "base": _errors(study, base, groups, smooth=False),
            "verdict": _errors(study, verdict, groups, smooth=False),
            "nameless": _errors(study, study.nameless.linearised, groups, smooth=True),
            "verdict_carried": _errors(study, verdict, groups, smooth=True),
        }
        out[factor] = {
            str(level): _means(rows, group)
            | {"without_chance": _means(rows, group[channel[group] != CHANCE])}
            for level, group in zip(np.unique(values).tolist(), groups, strict=True)
        }
        out[f"{factor} by observable"] = {
            str(name): _means(rows, np.flatnonzero(channel == name)) for name in np.unique(channel)
        }
    return out


def together(levels: Mapping[str, Any]) -> dict[str, Any]:
    """All levels of each factor in one: the means of its levels, weighed by their entries."""
    out: dict[str, Any] = {}
    for factor, rows in levels.items():
        if factor.endswith(" by observable"):
            continue
        out[factor] = _mean_of(list(rows.values()))
        out[factor]["without_chance"] = _mean_of([row["without_chance"] for row in rows.values()])
    return out


def _mean_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    weights = [row["entries"] for row in rows]
    return {
        name: float(np.average([row[name] for row in rows], weights=weights))
        for name in ("base", "verdict", "nameless", "verdict_carried")
    }


def _means(rows: Mapping[str, np.ndarray], entries: np.ndarray) -> dict[str, Any]:
    return {name: float(np.mean(error[entries])) for name, error in rows.items()} | {"entries": len(entries)}


def _errors(study: Study, fit: Linearised, groups: Sequence[np.ndarray], smooth: bool) -> np.ndarray:
    """Squared error of each entry over its repeats' variance, its level left out, (run entries,)."""
    left = leave_out(fit, groups)
    error = (left.conditional if smooth else left.prediction_error) @ fit.w
    return error[: study.data.run_entries] ** 2 / study.data.noise_sd[: study.data.run_entries] ** 2


if __name__ == "__main__":
    main()
