"""Measured and predicted against the factors at which the gap sits."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.reporting.drawing import BLUE, VERMILION, Picture, canvas, picture
from eaclutch.reporting.results import Results
from eaclutch.reporting.sentences import place_words
from eaclutch.reporting.words import FACTORS, Scale, number, observable_words, scale_for

ROUNDED = 5e-3  # a level is written with three digits


def where_figures(results: Results, most: int = 3) -> list[Picture]:
    """Measured and predicted against the factor, on left-out conditions, for the leading entries of ``where``."""
    pictures: list[Picture] = []
    seen: set[tuple[str, str]] = set()
    entries = sorted(results.diagnosis.get("where", []), key=lambda entry: -(entry.get("share") or 0))
    for entry in entries:
        factor = entry["factor"] if entry["factor"] in results.runs else "voltage_v"
        if len(pictures) < most and (entry["observable"], factor) not in seen:
            seen.add((entry["observable"], factor))
            drawn = _against_factor(results, entry, factor, len(pictures))
            if drawn:
                pictures.append(drawn)
    return pictures


def _against_factor(results: Results, entry: Mapping[str, Any], factor: str, index: int) -> Picture | None:
    name = entry["observable"]
    rows = results.predicted(name)
    table = rows.merge(results.runs[["run", factor]], on="run")
    if table.empty:
        return None
    info = results.observables.get(name)
    scale = scale_for(table["measured"], info.unit if info else "1")
    levels, label = _positions(table[factor])
    spread = 0.16
    with canvas(3.3) as (figure, axes):
        jitter = np.linspace(-spread / 2, spread / 2, len(table))
        axes.errorbar(
            levels - spread, scale(table["median"]),
            yerr=np.abs(scale(np.stack([table["median"] - table["q05"], table["q95"] - table["median"]]))),
            fmt="s", color=BLUE, ms=4, lw=0.8, alpha=0.5, label="predicted, 90 % interval",
        )  # fmt: skip
        axes.plot(
            levels + spread + jitter,
            scale(table["measured"]),
            "o",
            color=VERMILION,
            ms=4,
            alpha=0.8,
            label="measured",
        )
        axes.set_xticks(range(len(label)), label)
        axes.set(xlabel=FACTORS.get(factor, factor), ylabel=_axis(name, scale))
        if sum(map(len, label)) > 30:
            axes.tick_params(axis="x", labelrotation=45)
        figure.legend(loc="outside upper left", ncols=2)
        there = table[at_level(table[factor], str(entry["level"]))] if factor == entry["factor"] else table
        difference = float(np.median(scale(there["measured"] - there["median"])))
        held = bool((rows["held_out"].astype(str).str.lower() == "true").all())
        source = "left-out conditions" if held else "all conditions"
        return picture(
            figure,
            f"where-{index}",
            f"{observable_words(name)} measured and predicted against {FACTORS.get(factor, factor)}, {source}.",
            f"{place_words(entry)}. Measured less predicted: {number(difference, 2)} {scale.unit} in the median of "
            f"{len(there)} of the {len(table)} runs of {source}.",
        )


def at_level(values: pd.Series, level: str) -> pd.Series:
    """Which values lie at a level such as ``<=10``, ``>3``, a session's name or ``all``; (runs,) of bool."""
    if level.startswith("<="):
        return values <= float(level[2:]) * (1 + ROUNDED)
    if level.startswith(">"):
        return values > float(level[1:]) * (1 + ROUNDED)
    return values.astype(str) == level


def _positions(values: pd.Series) -> tuple[np.ndarray, list[str]]:
    """Categories 0, 1, ... of a factor's levels (numbers binned to at most eight) and their labels."""
    if pd.api.types.is_numeric_dtype(values):
        unique = np.unique(values.dropna())
        if len(unique) > 8:
            edges = np.unique(np.quantile(values.dropna(), np.linspace(0, 1, 6)))
            index = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
            return index, [f"{a:.2g}–{b:.2g}" for a, b in itertools.pairwise(edges)]
        return np.searchsorted(unique, values), [
            "DC" if u == 0.1 and values.name == "frequency_hz" else f"{u:g}" for u in unique
        ]
    names = sorted(values.unique())
    return np.array([names.index(value) for value in values]), [str(name) for name in names]


def _axis(name: str, scale: Scale) -> str:
    text = observable_words(name)
    return f"{text} ({scale.unit})" if scale.unit else f"{text} (1)"
