"""How well contact stiffness and roughness are known once the right effect is in the model, and how far off before.

    python benchmarks/constants_known.py --seed 20302 --work constants --each 6

Simulated campaigns of the open namespace of ``eaclutch.blind`` with one effect each, at 2-4 times
config/blind_limits.json; the effect is told, so that this counts intervals and not names. The contact law is free, as
in what a diagnosis says of them. In one of ten it is another one in part: all are counted, and once more those where it
holds. Each case is kept as soon as it is done.
``--record`` writes docs/measurements/constants_known.json.
"""

from __future__ import annotations

import os
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
from measurement import record
from nameless import share
from open_campaigns import Job, asked_singles, for_each, made
from scipy.special import ndtri

from eaclutch.diagnosis.contact_law import fit_contact_law
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.files import read_json, write_json

CONSTANTS = ("contact_stiffness", "roughness_sd")
REACH = float(ndtri(0.95))  # posterior sds of a 90 % interval


def main() -> None:
    chosen, entries = asked_singles(__doc__.splitlines()[0])
    for_each(fit_case, entries, chosen.work, chosen.jobs)
    cases = [read_json(chosen.work / "fitted" / f"{entry.case}.json") for entry in entries]
    holds = [case for case, entry in zip(cases, entries, strict=True) if entry.misfit == 0.0]
    result = {"cases": len(cases)} | {name: known(cases, name) for name in CONSTANTS}
    result["contact_law_holds"] = {"cases": len(holds)} | {name: known(holds, name) for name in CONSTANTS}
    print(result)
    if chosen.record:
        command = (
            f"python benchmarks/constants_known.py --seed {chosen.seed} --work constants --each {chosen.each}"
        )
        record("constants_known", command, result)


def fit_case(job: Job) -> None:
    """Fit one case without its effect and with it."""
    entry, work = job
    target = work / "fitted" / f"{entry.case}.json"
    if target.is_file():
        return
    answer, study = made(job)
    effects = tuple(name for name, _ in entry.effects)
    found = {}
    for when, fit in {"before": study.base, "after": study.fit(effects)}.items():
        _, free = fit_contact_law(study, fit.effects, fit.parameters, fit.multipliers)
        found[when] = errors(free, answer["parameters"])
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
