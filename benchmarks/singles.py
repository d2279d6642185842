"""How often an open campaign with one effect gets its name, and with what probability.

    python benchmarks/singles.py --seed 20023 --work singles --each 1

Simulated campaigns of the open namespace of ``eaclutch.blind``, sizes at 2-4 times config/blind_limits.json: a look
between two sealed sets at what a change of the method has cost. ``--record`` writes docs/measurements/singles.json.
"""

from __future__ import annotations

import os
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

from measurement import record
from nameless import share
from open_campaigns import asked_singles
from weighed import rows_left, weigh_all

from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import probabilities


def main() -> None:
    chosen, entries = asked_singles(__doc__.splitlines()[0])
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
