"""Batches of extracted runs to runs.csv, and runs.csv to the model's inputs."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.records import DC_LABEL, Bench, ObservableInfo, RunConditions
from eaclutch.rig.log_names import parse_log_name
from eaclutch.rig.observables import OBSERVABLES
from eaclutch.rig.preload import substrate_of

PRELOAD_EDGES = (0.25, 0.75, 1.5)  # N
LEADING = (
    "run", "session", "condition", "substrate", "voltage_v", "frequency_hz", "width_mm", "thickness_mm", "preload_n",
)  # fmt: skip
TRAILING = (
    "usable", "flags", "reasons", "drive_duration_s", "dwell_s", "run_order", "slip_fraction_sd_zero_known",
)  # fmt: skip


def observable_infos() -> list[ObservableInfo]:
    """What observables.json lists, in the order of the columns."""
    return [observable.info for observable in OBSERVABLES.values()]


def observables_markdown() -> str:
    """The observables as a table for the documentation."""
    lines = ["| observable | unit | phase | definition | resolution |", "|---|---|---|---|---|"]
    for info in observable_infos():
        resolution = "" if info.resolution is None else f"{info.resolution:g} {info.unit}"
        lines.append(f"| `{info.name}` | {info.unit} | {info.phase} | {info.definition} | {resolution} |")
    return "\n".join(lines)


def empty_row(run: str) -> dict[str, Any]:
    """A row with what the log's name says and nothing measured."""
    settings = parse_log_name(run)
    row: dict[str, Any] = {
        "run": settings.run,
        "substrate": settings.substrate,
        "voltage_v": settings.voltage,
        "frequency_hz": settings.frequency,
        "width_mm": settings.width * 1e3,
        "preload_n": np.nan,
        "usable": False,
        "flags": "",
        "reasons": "",
        "drive_duration_s": np.nan,
        "dwell_s": np.nan,
        "slip_fraction_sd_zero_known": np.nan,
    }
    return row | {column: np.nan for name in OBSERVABLES for column in (name, f"{name}_sd")}


def session_of(stamp: datetime, bench: Bench) -> str:
    """The session a run belongs to: the span that holds its stamp, else its date."""
    for span in bench.sessions or ():
        if span.start <= stamp <= span.end:
            return span.name
    return stamp.strftime("%Y-%m-%d")


def preload_bin(preload: float, edges: Sequence[float] = PRELOAD_EDGES) -> str:
    """Label of the preload bin, such as ``0.25-0.75N``; ``unknown`` for NaN."""
    if not np.isfinite(preload):
        return "unknown"
    bounds = ["0", *(f"{edge:g}" for edge in edges), "inf"]
    i = int(np.searchsorted(np.asarray(edges), preload, side="right"))
    return f"{bounds[i]}-{bounds[i + 1]}N"


def condition_of(row: pd.Series, edges: Sequence[float] = PRELOAD_EDGES) -> str:
    """The condition's label: substrate, width, thickness, voltage, frequency, preload bin."""
    frequency = "DC" if row["frequency_hz"] <= DC_LABEL else f"{row['frequency_hz']:g}Hz"
    return (
        f"{row['substrate']}_w{row['width_mm']:g}_t{row['thickness_mm']:g}_{row['voltage_v']:g}V_{frequency}"
        f"_p{preload_bin(row['preload_n'], edges)}"
    )


def runs_table(
    rows: Sequence[dict[str, Any]] | pd.DataFrame, bench: Bench, edges: Sequence[float] = PRELOAD_EDGES
) -> pd.DataFrame:
    """runs.csv from extracted rows: sorted by run, with session, condition, thickness and order in the session."""
    table = pd.DataFrame(rows).sort_values("run", ignore_index=True)
    settings = [parse_log_name(run) for run in table["run"]]
    table["session"] = [session_of(s.stamp, bench) for s in settings]
    table["thickness_mm"] = [substrate_of(s, bench)[1] * 1e3 for s in settings]
    table["condition"] = [condition_of(row, edges) for _, row in table.iterrows()]
    order = (
        table.assign(stamp=[s.stamp for s in settings]).groupby("session")["stamp"].rank(method="first") - 1
    )
    table["run_order"] = order.astype(int)
    names = [column for name in OBSERVABLES for column in (name, f"{name}_sd")]
    for column in ("flags", "reasons"):
        table[column] = table[column].fillna("").astype(str)
    return table[[*LEADING, *names, *TRAILING]]


def conditions_from_runs(
    runs: pd.DataFrame, bench: Bench | None = None, *, all_runs: bool = False
) -> RunConditions:
    """The model's inputs for the usable rows of runs.csv whose friction and drive duration are known.

    Those rows, in the table's order, are ``runs[runs["run"].isin(conditions.run)]``. ``all_runs`` keeps rows that
    are marked unusable, too.
    """
    known = runs["friction_before_n"].notna() & runs["drive_duration_s"].notna()
    if not all_runs:
        known &= runs["usable"].map(lambda value: str(value).lower() == "true")
    picked = runs[known]

    def column(name: str) -> np.ndarray:
        return picked[name].to_numpy(dtype=float)

    def names(name: str) -> tuple[str, ...]:
        return tuple(map(str, picked[name]))

    return RunConditions(
        run=names("run"),
        session=names("session"),
        condition=names("condition"),
        substrate=names("substrate"),
        voltage=column("voltage_v"),
        frequency=column("frequency_hz"),
        width=column("width_mm") * 1e-3,
        thickness=column("thickness_mm") * 1e-3,
        friction_before=column("friction_before_n"),
        switch_off_force=column("switch_off_force_n"),
        drive_duration=column("drive_duration_s"),
        dwell=column("dwell_s"),
        run_order=column("run_order"),
    )
