"""A small picture of every run: its force, with the time under voltage shaded, its flags and reasons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eaclutch.records import FloatArray
from eaclutch.reporting.results import Results
from eaclutch.reporting.words import number, observable_words

WIDTH, HEIGHT = 200, 64


@dataclass(frozen=True)
class Thumbnail:
    """A run on the page: name, what it was, whether it is used, flags, what it does
    not yield (by reason), why it is not used, and its picture (SVG path data)."""

    run: str
    title: str
    usable: bool
    flags: tuple[str, ...]
    reasons: tuple[str, ...]
    why: str
    path: str
    shade: tuple[float, float] | None
    force: str


MOST = 400  # pictures of a page; runs that are not used come before the others


def thumbnails(results: Results) -> list[Thumbnail]:
    """One a run, in the order of runs.csv; of a larger campaign those not used, then evenly spaced ones."""
    rows = results.runs.to_dict("records")
    if len(rows) > MOST:
        unused = [row for row in rows if not _used(row)][:MOST]
        used = [row for row in rows if _used(row)]
        step = max(1, -(-len(used) // max(MOST - len(unused), 1)))
        rows = unused + used[::step]
    return [_thumbnail(row, results) for row in rows]


def _used(row: dict) -> bool:
    return str(row["usable"]).lower() == "true"


def _thumbnail(row: dict, results: Results) -> Thumbnail:
    frequency = "DC" if row["frequency_hz"] == 0.1 else f"{row['frequency_hz']:g} Hz"
    trace = results.traces.get(row["run"])
    path, shade, force = _drawn(trace)
    by_reason: dict[str, list[str]] = {}
    for item in filter(None, str(row["reasons"]).split(";")):
        name, _, reason = item.partition(":")
        by_reason.setdefault(reason.replace("_", " "), []).append(observable_words(name))
    reasons = [f"{reason}: {', '.join(names)}" for reason, names in by_reason.items()]
    flags = tuple(flag.replace("_", " ") for flag in str(row["flags"]).split(";") if flag)
    excluded = (results.quality.get("excluded") or {}).get(row["run"])
    return Thumbnail(
        run=row["run"],
        title=f"{row['voltage_v']:g} V, {frequency}, {row['width_mm']:g} mm, {row['session']}",
        usable=_used(row),
        flags=flags,
        reasons=tuple(reasons),
        why=f"left out: {excluded}" if excluded else "; ".join(dict.fromkeys([*flags, *by_reason])),
        path=path,
        shade=shade,
        force=force,
    )


def _drawn(trace: FloatArray | None) -> tuple[str, tuple[float, float] | None, str]:
    """Path data, the shaded stretch (x, width), and the range of force in words."""
    if trace is None or len(trace) < 2:
        return "", None, ""
    time, force, driven = trace[:, 0], trace[:, 1], trace[:, 2] > 0.5
    low, high = float(np.min(force)), float(np.max(force))
    x = (time - time[0]) / max(float(np.ptp(time)), 1e-9) * WIDTH
    y = HEIGHT - 2 - (force - low) / max(high - low, 1e-9) * (HEIGHT - 4)
    path = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))
    shade = (round(float(x[driven][0]), 1), round(float(np.ptp(x[driven])), 1)) if driven.any() else None
    return path, shade, f"{number(low, 2)} to {number(high, 2)} N, {number(float(np.ptp(time)), 2)} s"
