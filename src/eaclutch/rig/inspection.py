"""One run for whoever stands at the rig: what was measured, how sure it is, what was wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from eaclutch.records import Bench, Recording
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.extract import extract_view
from eaclutch.rig.observables import OBSERVABLES
from eaclutch.rig.run_view import RunView


@dataclass(frozen=True)
class Inspection:
    """The repaired recording, the voltage's instants [s], usable observables (value, sd), and a table as text."""

    recording: Recording
    instants: dict[str, float]
    values: dict[str, tuple[float, float]]
    table: str


def inspect(recording: Recording, bench: Bench) -> Inspection:
    """Measure one recording as logged and put the result in words."""
    view, row = extract_view(recording, bench)
    instants = _instants(view)
    values = {
        name: (float(row[name]), float(row[f"{name}_sd"])) for name in OBSERVABLES if math.isfinite(row[name])
    }
    return Inspection(view.whole.recording, instants, values, _table(row, instants))


def _instants(view: RunView) -> dict[str, float]:
    try:
        events = view.events
    except Unusable:
        return {}
    return {"on": events.on, "stage_stop": events.stage_stop, "off": events.off}


def _table(row: dict[str, Any], instants: dict[str, float]) -> str:
    reasons = dict(item.split(":", 1) for item in row["reasons"].split(";") if item)
    lines = [row["run"], ""]
    for name, word in (("on", "voltage on"), ("stage_stop", "stage stops"), ("off", "voltage off")):
        if name in instants:
            lines.append(f"{word:24s} {instants[name]:10.5f} s")
    lines += [f"{'preload':24s} {row['preload_n']:10.3f} N", ""]
    for name, observable in OBSERVABLES.items():
        info = observable.info
        value = measured(row[name], row[f"{name}_sd"])
        text = (
            f"none: {reasons.get(name, '')}"
            if value is None
            else f"{value} {info.unit if info.unit != '1' else ''}"
        )
        resolved = "" if info.resolution is None else f"  (the rig resolves {info.resolution:g} {info.unit})"
        lines.append(f"{info.phase:9s}{name:24s} {text.rstrip()}{resolved if value else ''}")
    lines += [
        "",
        f"usable  {'yes' if row['usable'] else 'no'}",
        f"flags   {row['flags'].replace(';', ', ') or 'none'}",
    ]
    return "\n".join(lines)


def measured(value: float, sd: float) -> str | None:
    """``value +- sd``, the uncertainty to two digits and the value as far; None without a value."""
    if not (math.isfinite(value) and math.isfinite(sd)):
        return None
    if sd <= 0:
        return f"{value:.6g}"
    places = max(0, 1 - math.floor(math.log10(sd)))
    return f"{value:.{places}f} +- {sd:.{places}f}"
