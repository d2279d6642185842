"""What of a sealed benchmark's score is quoted: docs/measurements/blind.json from score.json.

snakemake --cores all unseal --config 'blind={size: blind_long, limits: <limits>, forecast: <confusion.json>}'
python benchmarks/blind_record.py results/blind/blind_long/score.json --method-commit <tag or commit>
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from measurement import record

from eaclutch.files import read_json

SHARES = ("right", "right_by_kind", "probability_of_truth_by_kind", "false_alarms", "unknown_recognised",
          "wrong_name_on_unknown", "wrong_name_on_effect", "set_holds_truth",
          "set_holds_truth_by_kind", "set_size", "identifiable", "closure",
          "parameters", "where", "left_out", "by_level", "by_effect", "by_distance", "seconds", "log_score", "brier",
          "frozen", "after_opening", "confusion", "strangers")  # fmt: skip
OF_RIVALS = ("right", "right_by_kind", "probability_of_truth_by_kind", "false_alarms", "log_score")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("score", type=Path)
    parser.add_argument(
        "--method-commit", required=True, help="tag or commit of the method when cases were sealed"
    )
    parser.add_argument("--name", default="blind", help="of the record")
    parser.add_argument("--note", help="what has to be known of this set")
    chosen = parser.parse_args()
    score: dict[str, Any] = read_json(chosen.score)
    methods = {
        name: {key: found[key] for key in (SHARES if name == "library" else OF_RIVALS) if key in found}
        for name, found in score["methods"].items()
    }
    size = chosen.score.parent.name
    command = (
        f"snakemake unseal --config 'blind={{size: {size}, ..}}', then python benchmarks/blind_record.py"
    )
    record(
        chosen.name,
        command,
        {"method_commit": chosen.method_commit, "kinds": score["kinds"], "methods": methods}
        | ({"note": chosen.note} if chosen.note else {}),
    )
    library = methods["library"]
    for key in ("right", "false_alarms", "unknown_recognised", "wrong_name_on_unknown"):
        share = library[key]
        print(
            f"{key}: {share['count']} of {share['of']} ({share['interval'][0]:.2f} to {share['interval'][1]:.2f})"
        )


if __name__ == "__main__":
    main()
