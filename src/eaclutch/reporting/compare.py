"""Two campaigns, or two models of one campaign, on one page: before and after a change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.reporting import sentences
from eaclutch.reporting.drawing import BLUE, INK, VERMILION, Picture, canvas, picture
from eaclutch.reporting.results import STAGES, Results
from eaclutch.reporting.templating import environment, style
from eaclutch.reporting.words import Scale, measured, percent, scale_for


@dataclass(frozen=True)
class Change:
    """A parameter on both sides: medians with intervals in one unit, and their distance in standard deviations."""

    stage: str
    name: str
    unit: str
    first: str
    second: str
    distance: float | None


def render_comparison(first: Results, second: Results) -> str:
    """The page as HTML."""
    sides = [
        {
            "name": side.name,
            "folder": side.folder.name,
            "runs": len(side.runs),
            "sentence": sentences.verdict_sentence(side.diagnosis),
            "caveats": sentences.caveats(side),
            "total": (side.diagnosis.get("gap") or {}).get("total") or {},
        }
        for side in (first, second)
    ]
    return (
        environment()
        .get_template("compare.html.j2")
        .render(
            style=style(),
            sides=sides,
            changes=changes(first.summary, second.summary),
            figure=effects_figure(first, second),
            observables=observables(first.diagnosis, second.diagnosis),
        )
    )


def changes(first: Mapping[str, Any], second: Mapping[str, Any]) -> list[Change]:
    """Parameters that both have, those that moved most first."""
    found = []
    for stage in STAGES:
        ours, theirs = (side.get(stage, {}).get("parameters", {}) for side in (first, second))
        for name in (name for name in ours if name in theirs):
            a, b = ours[name], theirs[name]
            scale = scale_for([a.get("median") or np.nan, b.get("median") or np.nan], a.get("unit") or "1")
            spread = np.hypot(a.get("sd") or 0.0, b.get("sd") or 0.0)
            distance = float((b["mean"] - a["mean"]) / spread) if spread > 0 else None
            label, unit = name.replace("_", " "), scale.unit or "1"
            found.append(
                Change(stage.replace("_", " "), label, unit, _shown(a, scale), _shown(b, scale), distance)
            )
    return sorted(found, key=lambda change: -abs(change.distance or 0.0))


def _shown(entry: Mapping[str, Any], scale: Scale) -> str:
    median, low, high = (
        None if entry.get(key) is None else float(scale(entry[key])) for key in ("median", "q05", "q95")
    )
    return measured(median, low, high)


def observables(
    first: Mapping[str, Any], second: Mapping[str, Any]
) -> list[tuple[str, str, list[float | None]]]:
    """Gap of each observable on both sides: name, unit, [before, noise floor] of the first, then of the second."""
    tables = [(side.get("gap") or {}).get("by_observable") or {} for side in (first, second)]
    rows: list[tuple[str, str, list[float | None]]] = []
    for name in dict.fromkeys([*tables[0], *tables[1]]):
        entries = [table.get(name, {}) for table in tables]
        values = [entry.get(key) for entry in entries for key in ("before", "noise_floor")]
        unit = next((entry["unit"] for entry in entries if entry.get("unit")), "1")
        scale = scale_for([value for value in values if value] or [np.nan], unit)
        rows.append((name, scale.unit or "1", [None if v is None else float(scale(v)) for v in values]))
    return rows


def effects_figure(first: Results, second: Results) -> Picture | None:
    """Probability of each cause on both sides."""
    sides = [
        {c["effect"]: c["probability"] for c in side.diagnosis.get("causes", [])} for side in (first, second)
    ]
    names = [
        name for name in dict.fromkeys([*sides[0], *sides[1]]) if max(s.get(name, 0.0) for s in sides) > 0.005
    ]
    if not names:
        return None
    names.sort(key=lambda name: max(side.get(name, 0.0) for side in sides))
    with canvas(1.1 + 0.36 * len(names)) as (figure, axes):
        for y, name in enumerate(names):
            axes.plot([side.get(name, 0.0) for side in sides], [y, y], color=INK, lw=0.8, zorder=1)
        axes.plot(
            [sides[0].get(n, 0.0) for n in names], range(len(names)), "o", color=VERMILION, label="first"
        )
        axes.plot(
            [sides[1].get(n, 0.0) for n in names],
            range(len(names)),
            "s",
            color=BLUE,
            mfc="white",
            mew=1.6,
            label="second",
        )
        axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
        axes.set(xlabel="probability (1)", xlim=(-0.03, 1.03))
        axes.grid(axis="y", visible=False)
        figure.legend(loc="outside upper left", ncols=2)
        listed = "; ".join(
            f"{n.replace('_', ' ')} {percent(sides[0].get(n, 0.0))} → {percent(sides[1].get(n, 0.0))}"
            for n in names[::-1][:3]
        )
        return picture(figure, "effects", "Probability of each cause, first and second.", f"{listed}.")
