"""posterior/summary.json: a table of all stages."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from eaclutch.inference import storage

FIXED = {"contact": ("stray_capacitance",)}  # part of the stage whether sampled or not


def summarise(paths: Sequence[Path]) -> dict[str, Any]:
    """{stage: {converged, source, parameters: {name: {mean, sd, q05, ...}}}} of the stages' files."""
    summary: dict[str, Any] = {}
    for path in paths:
        found = storage.load(Path(path))
        attributes = found.attributes
        names = list(found.prior_sd) + [
            name for name in FIXED if name in found.draws and name not in found.prior_sd
        ]
        diagnostics = {key: np.atleast_1d(attributes[key]) if key in attributes else None
                       for key in ("r_hat", "ess_bulk", "ess_tail")}  # fmt: skip
        sampled = json.loads(str(attributes.get("names", "[]")))
        parameters = {}
        for name in names:
            values = found.draws[name]
            q05, median, q95 = np.quantile(values, [0.05, 0.5, 0.95])
            row: dict[str, Any] = {
                "mean": np.mean(values), "sd": np.std(values), "q05": q05, "median": median, "q95": q95,
                "unit": found.units[name], "prior_sd": found.prior_sd.get(name, 0.0),
            }  # fmt: skip
            for key, array in diagnostics.items():
                known = array is not None and name in sampled
                row[key] = float(array[sampled.index(name)]) if known else None  # type: ignore[index]
            parameters[name] = row
        summary[str(attributes["stage"])] = {
            "converged": found.converged, "source": found.source, "parameters": parameters,
        }  # fmt: skip
    return summary


def sensitivities(paths: Sequence[Path]) -> dict[str, Any]:
    """posterior/sensitivity.json: {stage: {parameter: measures}}; null for a stage that rests on its prior."""
    found = {}
    for path in paths:
        attributes = storage.load(Path(path)).attributes
        text = attributes.get("sensitivity")
        found[str(attributes["stage"])] = json.loads(str(text)) if text is not None else None
    return found
