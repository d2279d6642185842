"""How often an open campaign with two effects gets both names, one of them, or a wrong one.

    python benchmarks/pairs.py --seed 20801 --work pairs --pairs 20

Simulated campaigns of the open namespace of ``eaclutch.blind``, two effects drawn at random in each, sizes at 2-4 times
config/blind_limits.json. ``--record`` writes docs/measurements/pairs.json. Each case is kept as soon as it is done.
"""

from __future__ import annotations

import os
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

from measurement import record
from nameless import share
from open_campaigns import LIMITS, parser_of
from singles import told
from weighed import weigh_all

from eaclutch.blind import plan
from eaclutch.files import read_json


def main() -> None:
    parser = parser_of(__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=20)
    chosen = parser.parse_args()
    entries = plan.make_plan(
        "dev", chosen.seed, none=0, unknown=0, pairs=chosen.pairs, limits=read_json(LIMITS)
    )
    said = told(weigh_all(entries, chosen.work, chosen.jobs))
    truths = [set(row["truth"].split(" and ")) for row in said]
    names = [set(row["said"].split(" and ")) - {"none", "unknown"} for row in said]
    result: dict[str, Any] = {
        "cases": len(said),
        "both": share(sum(a == b for a, b in zip(names, truths, strict=True)), len(said)),
        "one": sum(bool(a) and a < b for a, b in zip(names, truths, strict=True)),
        "wrong_name": share(sum(not a <= b for a, b in zip(names, truths, strict=True)), len(said)),
        "in_the_set": sum(row["truth"] in (row["said"], *row["alternatives"]) for row in said),
        "members": sum(len({row["said"], *row["alternatives"]}) for row in said) / len(said),
        "probability_of_truth": sum(row["probability_of_truth"] for row in said) / len(said),
        "said": said,
    }
    for row in said:
        print(row)
    print({name: value for name, value in result.items() if name != "said"})
    if chosen.record:
        command = f"python benchmarks/pairs.py --seed {chosen.seed} --work pairs --pairs {chosen.pairs}"
        record("pairs", command, result)


if __name__ == "__main__":
    main()
