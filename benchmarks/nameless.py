"""How often a campaign that deserves no name gets one.

    python benchmarks/nameless.py --seed 20018 --work nameless --none 150
    python benchmarks/nameless.py --seed 20020 --work nameless --unknown 60

The first makes simulated campaigns without an effect (docs/measurements/no_effect.json with ``--record``), the second
ones with an effect that the library lacks, at 2-4 times config/blind_limits.json (strangers.json); both of the open
namespace of ``eaclutch.blind``. Each case is kept as soon as it is done.
"""

from __future__ import annotations

import os
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

from measurement import record
from open_campaigns import LIMITS, parser_of
from scipy.stats import binomtest
from weighed import rows_left, weigh_all

from eaclutch.blind import plan
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import probabilities
from eaclutch.files import read_json


def share(count: int, of: int) -> dict[str, Any]:
    """A count with its exact 90 % interval."""
    low, high = binomtest(count, of).proportion_ci(0.9)
    return {"count": count, "of": of, "interval": [float(low), float(high)]}


def wrong_names(cases: Sequence[tuple[Mapping[str, Any], Any]]) -> dict[str, Any]:
    """What was said of each kind of campaign, and the shares of all that got a name, and ``unknown``."""
    thresholds = load_thresholds()
    said: dict[str, Counter[str]] = defaultdict(Counter)
    for answer, found in cases:
        put_in = " and ".join(entry["effect"] for entry in answer["effects"]) or "no effect"
        verdict = decide(probabilities(found, thresholds, rows_left(found)), found, thresholds).effects
        said[put_in][" and ".join(verdict) or "none"] += 1
    counts = sum(said.values(), Counter[str]())
    named = sum(count for verdict, count in counts.items() if verdict not in ("none", "unknown"))
    return {
        "cases": len(cases),
        "said": {put_in: dict(found) for put_in, found in sorted(said.items())},
        "named": share(named, len(cases)),
        "unknown": share(counts["unknown"], len(cases)),
    }


def main() -> None:
    parser = parser_of(__doc__.splitlines()[0])
    kind = parser.add_mutually_exclusive_group(required=True)
    kind.add_argument("--none", type=int, default=0, help="so many campaigns without an effect")
    kind.add_argument("--unknown", type=int, default=0, help="so many with an effect that the library lacks")
    chosen = parser.parse_args()
    limits = read_json(LIMITS)
    entries = plan.make_plan(
        "dev", chosen.seed, none=chosen.none, unknown=chosen.unknown, pairs=0, limits=limits
    )
    result = wrong_names(weigh_all(entries, chosen.work, chosen.jobs))
    print(result)
    if chosen.record:
        name, asked = ("no_effect", "none") if chosen.none else ("strangers", "unknown")
        command = f"python benchmarks/nameless.py --seed {chosen.seed} --work nameless"
        record(name, f"{command} --{asked} {getattr(chosen, asked)}", result)


if __name__ == "__main__":
    main()
