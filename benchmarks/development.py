"""The development set, and the numbers of thresholds.yaml that are fitted on it.

    python benchmarks/development.py --seed 9001 --work development --jobs 2

makes simulated campaigns (the open namespace of ``eaclutch.blind``: no sealed case is ever among them), weighs every
hypothesis on each, and fits temperature, prior odds and the cost of a remainder by the mean log score. Prints what the
fitted numbers and the present ones make of the set, and what the right name gained at each size: what
config/blind_limits.json is set by. ``--forecast`` also writes what the design of the set's first campaign without an
effect could tell apart (confusion.json, for ``blind.forecast``). Each case is kept as soon as it is done.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
from measurement import record
from open_campaigns import parser_of
from scipy.optimize import minimize
from scipy.special import expit, logit, softmax
from weighed import rows_left, weigh_all

from eaclutch.blind import plan
from eaclutch.cli.blind_methods import read_case
from eaclutch.diagnosis.forecast import Forecast
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import probabilities
from eaclutch.files import write_json

SIZES = (0.6, 3.0)  # of the magnitudes in the literature
COUNTS = {"none": 24, "unknown": 26, "each_single": 4, "pairs": 8}
WEIGHTS = {"none": 2.0, "unknown": 1.0, "single": 1.0, "pair": 0.5}  # of a kind of case in the fit
FLOOR = 0.01  # a probability below it costs no more: one lost case must not rule the fit


def adjusted(thresholds: Mapping[str, Any], x: np.ndarray) -> dict[str, Any]:
    """Thresholds with the fitted numbers (5,) in."""
    none, unknown, _ = softmax([x[1], x[2], 0.0])
    fitted = {"none": float(none), "unknown": float(unknown), "pair_share": float(expit(x[3]))}
    prior = dict(thresholds["prior"]) | fitted
    return dict(thresholds) | {
        "temperature": float(np.exp(x[0])),
        "prior": prior,
        "remainder_cost": float(np.exp(x[4])),
    }


def start(thresholds: Mapping[str, Any]) -> np.ndarray:
    """Inverse of ``adjusted``."""
    prior = thresholds["prior"]
    named = 1.0 - prior["none"] - prior["unknown"]
    odds = [np.log(prior[name] / named) for name in ("none", "unknown")]
    return np.array([np.log(thresholds["temperature"]), *odds, logit(prior["pair_share"]),
                     np.log(thresholds["remainder_cost"])])  # fmt: skip


def loss(
    x: np.ndarray, thresholds: Mapping[str, Any], cases: Sequence[tuple[Mapping[str, Any], Any]]
) -> float:
    """Mean weighted log score, the lower the better."""
    total = 0.0
    for answer, rows in cases:
        found = probabilities(rows, adjusted(thresholds, x), rows_left(rows))
        weights = {frozenset(k): v for k, v in found.items()}
        total -= WEIGHTS[answer["kind"]] * np.log(max(weights.get(frozenset(answer["verdict"]), 0.0), FLOOR))
    return total / len(cases)


def outcome(thresholds: Mapping[str, Any], cases: Sequence[tuple[Mapping[str, Any], Any]]) -> dict[str, Any]:
    """Shares by kind of case: right verdict, named, probability on the truth, truth in the set, its size."""
    rows: dict[str, list[list[float]]] = defaultdict(list)
    for answer, found in cases:
        weights = probabilities(found, thresholds, rows_left(found))
        verdict = decide(weights, found, thresholds)
        truth = frozenset(answer["verdict"])
        offered = [frozenset(verdict.effects), *map(frozenset, verdict.alternatives)]
        p = {frozenset(k): v for k, v in weights.items()}.get(truth, 0.0)
        named = verdict.effects not in ((), ("unknown",))
        rows[answer["kind"]].append([offered[0] == truth, named, p, truth in offered, len(offered)])
    heads = ("right", "named", "probability", "in_set", "members")
    return {
        kind: {"cases": len(found)}
        | dict(zip(heads, np.round(np.mean(found, axis=0), 3).tolist(), strict=True))
        for kind, found in rows.items()
    }


def gains(cases: Sequence[tuple[Mapping[str, Any], Any]]) -> dict[str, list[tuple[float, float]]]:
    """(size, nats that the right answer gains over no effect) of each effect that was put in alone, by size."""
    found: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for answer, rows in cases:
        if answer["kind"] in ("single", "unknown"):
            (put_in,) = answer["effects"]
            plain = max(row.log_evidence_without for row in rows)
            named = {row.effects: row.log_evidence for row in rows}
            right = named.get((put_in["effect"],), max(row.log_evidence_without_open for row in rows))
            found[put_in["effect"]].append((round(put_in["size"], 2), round(right - plain, 1)))
    return {effect: sorted(pairs) for effect, pairs in sorted(found.items())}


def main() -> None:
    parser = parser_of(__doc__.splitlines()[0])
    parser.add_argument("--forecast", type=Path, help="confusion.json to write")
    chosen = parser.parse_args()
    plan.SIZE_RANGE = SIZES
    command = f"python benchmarks/development.py --seed {chosen.seed} --work development"
    cases = weigh_all(plan.make_plan("dev", chosen.seed, **COUNTS), chosen.work, chosen.jobs)
    present = load_thresholds()
    if chosen.forecast:
        plain = next(answer["case"] for answer, _ in cases if answer["kind"] == "none")
        study = Study(read_case(chosen.work / "cases" / plain, "library", {}), present)
        write_json(chosen.forecast, Forecast(study).document(np.random.default_rng(chosen.seed)))
    for effect, pairs in gains(cases).items():
        print(effect, *(f"{size:g}: {nats:g}" for size, nats in pairs))
    found = minimize(
        loss, start(present), args=(present, cases), method="Nelder-Mead", options={"maxfev": 600}
    )
    fitted = adjusted(present, found.x)
    result = {"counts": COUNTS, "sizes": SIZES, "present": outcome(present, cases), "fitted": outcome(fitted, cases),
              "fitted_numbers": {key: fitted[key] for key in ("temperature", "prior", "remainder_cost")}}  # fmt: skip
    for key, value in result.items():
        print(key, value)
    if chosen.record:
        record("development", command, result)


if __name__ == "__main__":
    main()
