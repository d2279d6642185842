"""How well contact stiffness and roughness are known once the right effect is in the model, and how far off before.

    python benchmarks/constants_known.py --seed 20302 --work constants --each 6

Simulated campaigns of the open namespace of ``eaclutch.blind`` with one effect each, at 2-4 times
config/blind_limits.json; the effect is told, so that this counts intervals and not names. Each case is kept as soon as
it is done. ``--record`` writes docs/measurements/constants_known.json.
"""

from __future__ import annotations

import argparse
import os
from multiprocessing import Pool
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
from measurement import record
from nameless import LIMITS, share
from scipy.special import ndtri

from eaclutch.blind import plan
from eaclutch.blind.generate import generate_case, write_tables
from eaclutch.cli.blind_methods import read_case
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.files import read_json, write_json

CONSTANTS = ("contact_stiffness", "roughness_sd")
REACH = float(ndtri(0.95))  # posterior sds of a 90 % interval


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--each", type=int, default=1, help="campaigns an effect")
    parser.add_argument("--record", action="store_true")
    chosen = parser.parse_args()
    entries = plan.make_plan(
        "dev", chosen.seed, none=0, unknown=0, each_single=chosen.each, pairs=0, limits=read_json(LIMITS)
    )
    with Pool(chosen.jobs) as pool:
        jobs = [(entry, chosen.work) for entry in entries]
        for done, _ in enumerate(pool.imap_unordered(fit_case, jobs), 1):
            print(f"{done} of {len(entries)}", flush=True)
    cases = [read_json(chosen.work / "fitted" / f"{entry.case}.json") for entry in entries]
    result = {"cases": len(cases)} | {name: known(cases, name) for name in CONSTANTS}
    print(result)
    if chosen.record:
        command = (
            f"python benchmarks/constants_known.py --seed {chosen.seed} --work constants --each {chosen.each}"
        )
        record("constants_known", command, result)


def fit_case(job: tuple[plan.Entry, Path]) -> None:
    """Make one case and fit it without its effect and with it."""
    entry, work = job
    target = work / "fitted" / f"{entry.case}.json"
    if target.is_file():
        return
    tables, answer = generate_case(entry)
    folder = work / "cases" / entry.case
    write_tables(tables, folder)
    study = Study(read_case(folder, "library", {}), load_thresholds())
    effects = tuple(name for name, _ in entry.effects)
    found = {
        when: errors(fit, answer["parameters"])
        for when, fit in (("before", study.base), ("after", study.fit(effects)))
    }
    write_json(target, {"effects": list(effects), **found})


def errors(fit: HypothesisFit, truth: dict[str, float]) -> dict[str, dict[str, float]]:
    """Of each constant: fitted less true [posterior sd], and that sd over the truth."""
    sd = dict(zip(fit.mode.names, fit.sd.tolist(), strict=True))
    return {
        name: {"error": (fit.parameters[name] - truth[name]) / sd[name], "sd": sd[name] / truth[name]}
        for name in CONSTANTS
    }


def known(cases: list[dict[str, Any]], name: str) -> dict[str, Any]:
    """Cover of 90 % intervals, mean error with its standard error and mean size of the error [posterior sd], mean
    posterior sd and root mean square error [share of the truth]; by the model without the effect and with it."""
    out: dict[str, Any] = {}
    for when in ("before", "after"):
        error = np.array([case[when][name]["error"] for case in cases])
        sd = np.array([case[when][name]["sd"] for case in cases])
        out[when] = {
            "covered": share(int(np.sum(np.abs(error) <= REACH)), len(cases)),
            "bias": float(np.mean(error)),
            "bias_se": float(np.std(error, ddof=1) / np.sqrt(len(cases))),
            "mean_size": float(np.mean(np.abs(error))),
            "sd": float(np.mean(sd)),
            "rms_error": float(np.sqrt(np.mean((error * sd) ** 2))),
        }
    return out


if __name__ == "__main__":
    main()
