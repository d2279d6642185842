"""How often an open campaign with one effect gets its name, and with what probability.

    python benchmarks/singles.py --seed 20023 --work singles --each 1

Simulated campaigns of the open namespace of ``eaclutch.blind``, sizes at 2-4 times config/blind_limits.json: a look
between two sealed sets at what a change of the method has cost. ``--record`` writes docs/measurements/singles.json.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

from measurement import record
from nameless import share
from open_campaigns import asked_singles
from weighed import Weighed, rows_left, weigh_all

from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import probabilities


def main() -> None:
    chosen, entries = asked_singles(__doc__.splitlines()[0])
    said = told(weigh_all(entries, chosen.work, chosen.jobs))
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


def told(cases: Sequence[tuple[Mapping[str, Any], Sequence[Weighed]]]) -> list[dict[str, Any]]:
    """What is said of each case, (answer, hypotheses), by the rules as they are, in the order of what is true."""
    thresholds, said = load_thresholds(), []
    for answer, found in cases:
        weights = probabilities(found, thresholds, rows_left(found))
        verdict = decide(weights, found, thresholds)
        truth = sorted(entry["effect"] for entry in answer["effects"])
        said.append(
            {
                "truth": " and ".join(truth),
                "said": " and ".join(sorted(verdict.effects)) or "none",
                "probability_of_truth": sum(p for e, p in weights.items() if sorted(e) == truth),
                "alternatives": [" and ".join(sorted(a)) or "none" for a in verdict.alternatives],
            }
        )
    return sorted(said, key=lambda row: row["truth"])


if __name__ == "__main__":
    main()
