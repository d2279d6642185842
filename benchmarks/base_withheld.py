"""Does an effect of the base model come back where the model is told to leave it out?

    python benchmarks/base_withheld.py --seed 20701 --work base-withheld --each 2

Simulated campaigns of the open namespace of ``eaclutch.blind``, in which every base effect acts: ``--each`` for each of
them without another effect, as many with one candidate beside it, and one with two, at 2-4 times
config/blind_limits.json. Each is diagnosed with a model that lacks the one base effect. ``--record`` writes
docs/measurements/base_withheld.json.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

from measurement import record
from open_campaigns import LIMITS, Job, for_each, made, parser_of
from weighed import kept, read_case, rows_left, weigh_campaign

from eaclutch.blind import plan
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import probabilities
from eaclutch.files import read_json
from eaclutch.physics.effects import BASE


def main() -> None:
    parser = parser_of(__doc__.splitlines()[0])
    parser.add_argument(
        "--each", type=int, default=1, help="campaigns a base effect, and as many with a candidate"
    )
    chosen = parser.parse_args()
    count, limits = chosen.each * len(BASE), read_json(LIMITS)
    one = plan.make_plan("dev", chosen.seed, none=count, unknown=0, singles=count, pairs=0, limits=limits)
    prefix = f"dev-{chosen.seed}-two"
    two = plan.make_plan("dev", chosen.seed, none=0, unknown=0, pairs=len(BASE), limits=limits, prefix=prefix)
    entries = [*one, *two]
    for_each(weigh_without, entries, chosen.work, chosen.jobs)
    said = sorted((said_of(entry, chosen.work) for entry in entries), key=lambda row: row["truth"])
    for row in said:
        print(row)
    if chosen.record:
        command = f"python benchmarks/base_withheld.py --seed {chosen.seed} --work base-withheld --each {chosen.each}"
        record("base_withheld", command, counted(said) | {"said": said})


def counted(said: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """How many cases, in how many the verdict holds what was withheld, the set of alternatives does, and every name of
    the verdict is true."""
    names = [set(row["said"].split(" and ")) - {"none"} for row in said]
    truths = [set(row["truth"].split(" and ")) for row in said]
    return {
        "cases": len(said),
        "named": sum(row["withheld"] in found for row, found in zip(said, names, strict=True)),
        "in_the_set": sum(
            row["withheld"] in found.union(*(a.split(" and ") for a in row["alternatives"]))
            for row, found in zip(said, names, strict=True)
        ),
        "no_wrong_name": sum(found <= truth for found, truth in zip(names, truths, strict=True)),
    }


def withheld_of(entry: plan.Entry) -> str:
    """The base effect that the model of a case lacks: by its place in the plan, whose order is random."""
    return BASE[int(entry.case.rsplit("-", 1)[1]) % len(BASE)]


def weigh_without(job: Job) -> None:
    """Make one case and weigh every hypothesis on it by a model without one base effect."""
    if kept(job).is_file():
        return
    name = withheld_of(job[0])
    answer, study = made(job)
    effects = tuple(effect for effect in study.inputs.effects if effect != name)
    inputs = replace(study.inputs, effects=effects, candidates=(name, *study.inputs.candidates))
    weigh_campaign(job, answer, Study(inputs, load_thresholds()))


def said_of(entry: plan.Entry, work: Path) -> dict[str, Any]:
    """What is said of a case by the rules as they are."""
    thresholds = load_thresholds()
    _, found = read_case((entry, work))
    weights = probabilities(found, thresholds, rows_left(found))
    verdict = decide(weights, found, thresholds)
    name = withheld_of(entry)
    truth = sorted([name, *(effect for effect, _ in entry.effects)])
    return {
        "withheld": name,
        "truth": " and ".join(truth),
        "said": " and ".join(verdict.effects) or "none",
        "probability": verdict.probability,
        "probability_of_truth": next((p for e, p in weights.items() if sorted(e) == truth), 0.0),
        "probability_of_withheld": sum(p for e, p in weights.items() if name in e),
        "alternatives": [" and ".join(a) or "none" for a in verdict.alternatives],
    }


if __name__ == "__main__":
    main()
