"""A batch of runs to rows, and batches to the campaign's tables: what the workflow's jobs call."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from eaclutch.records import Bench, FloatArray
from eaclutch.rig import published
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.extract import extract_view
from eaclutch.rig.hidden_wave import habit
from eaclutch.rig.log_names import run_of
from eaclutch.rig.logs import read_log
from eaclutch.rig.run_view import RunView
from eaclutch.rig.table import PRELOAD_EDGES, empty_row, runs_table
from eaclutch.rig.traces import trace

EXCLUDED = "excluded"


@dataclass(frozen=True)
class Batch:
    """Rows of runs.csv (without session and condition), rows of runs_published.csv, thinned forces by run."""

    runs: list[dict[str, Any]]
    published: list[dict[str, Any]]
    traces: dict[str, FloatArray]


def extract_batch(paths: Iterable[Path], bench: Bench) -> Batch:
    """Extract the logs at ``paths``; a run that the bench excludes is not even read.

    Whether the drive finishes its half waves is its habit: where most of the batch's runs show it, it counts for those
    that leave it open. Raises InputError naming file and row for a log that cannot be read.
    """
    batch = Batch([], [], {})
    shown: list[bool | None] = []
    left_open: dict[int, Path] = {}
    for path in paths:
        run = run_of(path)
        reason = bench.exclude.get(run)
        if reason is not None:
            batch.runs.append(empty_row(run) | {"flags": EXCLUDED, "reasons": f"run:{reason}"})
            batch.published.append({"run": run, "kept": False, "reason": EXCLUDED})
            continue
        recording = read_log(path)
        view, row = extract_view(recording, bench)
        finishes, undecided = _end_of_drive(view)
        shown.append(finishes)
        if undecided:
            left_open[len(batch.runs)] = path
        batch.runs.append(row)
        batch.published.append(published.published(recording))
        batch.traces[run] = trace(recording)
    usual = habit(shown)
    if usual is not None:
        for index, path in left_open.items():
            batch.runs[index] = extract_view(read_log(path), bench, usual)[1]
    return batch


def _end_of_drive(view: RunView) -> tuple[bool | None, bool]:
    """Whether a run shows that its drive finishes half waves, and whether other runs would say more of its own end."""
    try:
        return view.events.finishes, view.events.left_open
    except Unusable:
        return None, False


def join_batches(
    batches: Sequence[pd.DataFrame], bench: Bench, edges: Sequence[float] = PRELOAD_EDGES
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """runs.csv and the content of quality.json (counts of flags and of reasons) from the batches' tables."""
    rows = pd.concat([batch for batch in batches if len(batch)], ignore_index=True)
    runs = runs_table(rows, bench, edges)
    out = runs["run"].isin(bench.exclude.keys())
    runs.loc[out, "usable"] = False
    runs.loc[out, "flags"] = [_with(flags, EXCLUDED) for flags in runs.loc[out, "flags"]]
    return runs, _quality(runs, {run: bench.exclude[run] for run in runs.loc[out, "run"]})


def _with(flags: str, flag: str) -> str:
    return ";".join(sorted({flag, *filter(None, flags.split(";"))}))


def _quality(runs: pd.DataFrame, excluded: Mapping[str, str]) -> dict[str, Any]:
    flags = Counter(flag for text in runs["flags"] for flag in text.split(";") if flag)
    unusable: dict[str, Counter[str]] = {}
    for text in runs["reasons"]:
        for item in filter(None, text.split(";")):
            name, _, reason = item.partition(":")
            unusable.setdefault(name, Counter())[reason] += 1
    return {
        "schema": 1,
        "runs": len(runs),
        "usable": int(runs["usable"].sum()),
        "flags": dict(flags),
        "unusable": {name: dict(reasons) for name, reasons in unusable.items()},
        "excluded": dict(excluded),
    }
