"""How large the gap is, where it sits, and what explains it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.reporting.drawing import BLUE, GREEN, GREY, INK, VERMILION, Picture, canvas, picture
from eaclutch.reporting.results import Results
from eaclutch.reporting.words import (
    FACTORS,
    Scale,
    effect_words,
    number,
    observable_words,
    percent,
    scale_for,
)

CLIPPED_AT = 120.0  # %; a value that is typically near zero would squeeze all others


def closure_figure(diagnosis: Mapping[str, Any]) -> Picture | None:
    """The total gap on left-out conditions before and after the verdict, against the noise floor."""
    closure = diagnosis.get("closure") or {}
    total = (diagnosis.get("gap") or {}).get("total") or {}
    before = _first(closure.get("before"), total.get("before"))
    floor = _first(closure.get("noise_floor"), total.get("noise_floor"))
    after = closure.get("after")
    if before is None or floor is None:
        return None
    bars = [("model as it is", before, VERMILION)]
    named = diagnosis["verdict"]["effects"]
    if after is not None and named and named != ["unknown"]:
        bars.append((f"with {effect_words(named)}", after, GREEN))
    with canvas(1.2 + 0.42 * len(bars)) as (figure, axes):
        for row, (_, value, colour) in enumerate(bars):
            axes.barh(row, value, color=colour, height=0.62)
        interval = total.get("interval")
        ends = [value for _, value, _ in bars]
        if interval and None not in interval:
            ends[0] = max(before, interval[1])
        for row, (_, value, _) in enumerate(bars):
            axes.text(ends[row], row, f"  {number(value)}", va="center", ha="left", color=INK)
        if interval and None not in interval:
            axes.errorbar(
                before,
                -0.0,
                xerr=[[max(before - interval[0], 0)], [max(interval[1] - before, 0)]],
                color=INK,
                capsize=3,
                lw=1,
            )
        axes.axvline(floor, color=INK, ls="--", lw=1.2)
        axes.text(floor, -0.42, f" noise floor {number(floor)}", ha="left", va="bottom", fontsize=9)
        axes.set_yticks(range(len(bars)), [_wrapped(label) for label, *_ in bars])
        axes.set(
            xlabel="mean squared error / repeat variance (1)",
            xlim=(0, max(*ends, floor) * 1.25),
            ylim=(len(bars) - 0.5, -0.75),
        )
        axes.grid(axis="y", visible=False)
        text = ", ".join(f"{label} {number(value)}" for label, value, _ in bars)
        return picture(
            figure,
            "closure",
            f"Bars of the gap on left-out conditions: {text}; noise floor {number(floor)}.",
            f"How far: {text}; a perfect model would reach about {number(floor)}. Conditions that the fit did not see.",
        )


def by_observable_figure(results: Results) -> Picture | None:
    """Gap of each observable before and after, as a part of its typical measured size."""
    entries = (results.diagnosis.get("gap") or {}).get("by_observable") or {}
    rows = []
    for name, entry in entries.items():
        size = float(results.runs[name].abs().median()) if name in results.runs else 0.0
        if size > 0 and entry.get("before") is not None:
            rows.append((name, size, entry))
    if not rows:
        return None
    rows.sort(key=lambda row: row[2]["before"] / row[1])
    with canvas(1.4 + 0.3 * len(rows)) as (figure, axes):
        for y, (_, size, entry) in enumerate(rows):
            share = 100 / size
            significant = (entry.get("p_value") if entry.get("p_value") is not None else 1) < 0.05
            if entry.get("noise_floor") is not None:
                axes.plot(entry["noise_floor"] * share, y, "|", color=INK, ms=13, mew=1.6)
            if entry.get("after") is not None:
                axes.plot(
                    [entry["before"] * share, entry["after"] * share], [y, y], color=GREY, lw=1.2, zorder=1
                )
                axes.plot(entry["after"] * share, y, "s", color=GREEN, ms=7, mfc="white", mew=1.6)
            axes.plot(entry["before"] * share, y, "o", color=VERMILION if significant else GREY, ms=5.5)
        largest = [100 * max(entry["before"], entry.get("after") or 0) / size for _, size, entry in rows]
        for y, value in enumerate(largest):
            if value > CLIPPED_AT:
                axes.text(
                    CLIPPED_AT, y, f"{value:.0f} % → ", ha="right", va="center", fontsize=9,
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
                )  # fmt: skip
        end = CLIPPED_AT if max(largest) > CLIPPED_AT else None
        axes.set_yticks(range(len(rows)), [observable_words(name) for name, *_ in rows])
        axes.set(xlabel="gap (% of the typical measured value)", xlim=(0, end), ylim=(-0.6, len(rows) - 0.4))
        axes.grid(axis="y", visible=False)
        handles = [
            axes.plot([], [], "o", color=VERMILION, label="as it is, p < 0.05")[0],
            axes.plot([], [], "o", color=GREY, label="as it is, p ≥ 0.05")[0],
            axes.plot([], [], "s", color=GREEN, mfc="white", mew=1.6, label="with the verdict")[0],
            axes.plot([], [], "|", color=INK, ms=13, mew=1.6, ls="", label="noise floor")[0],
        ]
        figure.legend(handles=handles, loc="outside upper left", ncols=2, fontsize=8.5)
        name, _, worst = rows[-1]
        info = results.observables.get(name)
        scale = scale_for([worst["before"]], info.unit if info else "1")
        return picture(
            figure,
            "by-observable",
            "Dots of the gap of each observable, before and after the verdict, with its noise floor.",
            f"Largest for its size: {observable_words(name)}, {number(float(scale(worst['before'])))} {scale.unit} "
            f"against a noise floor of {number(float(scale(worst.get('noise_floor') or 0)))} {scale.unit}".strip()
            + ".",
        )


def hypotheses_figure(diagnosis: Mapping[str, Any], shown: int = 8) -> Picture | None:
    """Probabilities of the leading hypotheses."""
    entries = sorted(diagnosis.get("hypotheses", []), key=lambda entry: -entry["probability"])[:shown]
    if not entries:
        return None
    entries.reverse()
    named = diagnosis["verdict"]["effects"]
    with canvas(0.9 + 0.34 * len(entries)) as (figure, axes):
        for y, entry in enumerate(entries):
            colour = BLUE if entry["effects"] == named else GREY
            axes.barh(y, entry["probability"], color=colour, height=0.62)
            axes.text(entry["probability"], y, f" {percent(entry['probability'])}", va="center", fontsize=9)
        axes.set_yticks(range(len(entries)), [_wrapped(effect_words(entry["effects"])) for entry in entries])
        axes.set(xlabel="probability (1)", xlim=(0, 1.14), xticks=[0, 0.25, 0.5, 0.75, 1])
        axes.grid(axis="y", visible=False)
        best = entries[-1]
        return picture(
            figure,
            "hypotheses",
            "Bars of the probability of each hypothesis.",
            f"Which: {effect_words(best['effects'])} leads with {percent(best['probability'])} of "
            f"{len(diagnosis['hypotheses'])} hypotheses weighed. Blue: the verdict.",
        )


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
        difference = float(np.median(scale(table["measured"] - table["median"])))
        held = bool((rows["held_out"].astype(str).str.lower() == "true").all())
        source = "left-out conditions" if held else "all conditions"
        return picture(
            figure,
            f"where-{index}",
            f"{observable_words(name)} measured and predicted against {FACTORS.get(factor, factor)}, {source}.",
            f"{observable_words(name).capitalize()}, {len(table)} runs of {source}: measured less predicted is "
            f"{number(difference, 2)} {scale.unit} in the median.",
        )


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


def _wrapped(text: str, width: int = 20) -> str:
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + len(word) >= width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)


def _first(*values: float | None) -> float | None:
    return next((value for value in values if value is not None), None)
