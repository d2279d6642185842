"""A batch of runs to rows, and batches to the campaign's tables: what the workflow's jobs call."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import pandas as pd

from eaclutch.records import Bench, LogFile
from eaclutch.rig.extract import extract
from eaclutch.rig.logs import read_log
from eaclutch.rig.table import PRELOAD_EDGES, runs_table

EXCLUDED = "excluded"


def extract_campaign(logs: Iterable[LogFile], bench: Bench) -> list[dict[str, Any]]:
    """One row a log (see ``extract``); a run that campaign.yaml excludes is not even read.

    Raises InputError naming file and row for a log that cannot be read.
    """
    rows = []
    for log in logs:
        reason = bench.exclude.get(log.settings.run)
        if reason is None:
            rows.append(extract(read_log(log.path), bench))
        else:
            rows.append(
                {"run": log.settings.run, "flags": EXCLUDED, "reasons": f"run:{reason}", "usable": False}
            )
    return rows


def join_batches(
    batches: Sequence[pd.DataFrame], bench: Bench, edges: Sequence[float] = PRELOAD_EDGES
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """runs.csv and the content of quality.json (counts of flags and of reasons) from the batches' tables."""
    rows = pd.concat([batch for batch in batches if len(batch)], ignore_index=True)
    runs = runs_table(rows, bench, edges)
    flags = Counter(flag for text in runs["flags"] for flag in text.split(";") if flag)
    reasons: Counter[str] = Counter()
    for text in runs["reasons"]:
        reasons.update(item for item in text.split(";") if item)
    by_observable: dict[str, dict[str, int]] = {}
    for item, number in reasons.items():
        name, _, reason = item.partition(":")
        by_observable.setdefault(name, {})[reason] = number
    quality = {
        "schema": 1,
        "runs": len(runs),
        "usable": int(runs["usable"].sum()),
        "flags": dict(flags),
        "unusable": by_observable,
        "excluded": {run: reason for run, reason in bench.exclude.items() if run in set(runs["run"])},
    }
    return runs, quality
