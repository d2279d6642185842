"""How often an open campaign with one effect gets its name, and with what probability.

    python benchmarks/singles.py --seed 20023 --work singles --each 1

Simulated campaigns of the open namespace of ``eaclutch.blind``, sizes at 2-4 times config/blind_limits.json: a look
between two sealed sets at what a change of the method has cost. ``--record`` writes docs/measurements/singles.json.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

from measurement import record
from nameless import LIMITS, share
from weighed import rows_left, weigh_all

from eaclutch.blind import plan
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import probabilities
from eaclutch.files import read_json


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
    thresholds, said = load_thresholds(), []
    for answer, found in weigh_all(entries, chosen.work, chosen.jobs):
        weights = probabilities(found, thresholds, rows_left(found))
        verdict = decide(weights, found, thresholds)
        (truth,) = (entry["effect"] for entry in answer["effects"])
        said.append(
            {
                "truth": truth,
                "said": " and ".join(verdict.effects) or "none",
                "probability_of_truth": weights.get((truth,), 0.0),
                "alternatives": [" and ".join(a) or "none" for a in verdict.alternatives],
            }
        )
    said.sort(key=lambda row: row["truth"])
    result: dict[str, Any] = {
        "cases": len(said),
        "right": share(sum(row["said"] == row["truth"] for row in said), len(said)),
        "probability_of_truth": sum(row["probability_of_truth"] for row in said) / len(said),
        "said": said,
    }
    for row in said:
        print(row)
    print(result["right"], result["probability_of_truth"])
    if chosen.record:
        command = f"python benchmarks/singles.py --seed {chosen.seed} --work singles --each {chosen.each}"
        record("singles", command, result)


if __name__ == "__main__":
    main()
