"""How large the gap is, and what explains it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from eaclutch.reporting.drawing import BLUE, GREEN, GREY, INK, VERMILION, Picture, canvas, picture
from eaclutch.reporting.results import Results
from eaclutch.reporting.words import (
    effect_words,
    holds_the_pair,
    number,
    observable_words,
    percent,
    scale_for,
)

MOST, LEAST = 6, 0.01  # bars of the hypotheses, and the probability below which one is not drawn by itself
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
            axes.annotate(number(value), (ends[row], row), (6, 0), textcoords="offset points", va="center")
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
        axes.annotate(
            f"noise floor {number(floor)}",
            (floor, -0.42),
            (4, 0),
            textcoords="offset points",
            va="bottom",
            fontsize=9,
        )
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
            f"How far: {text}; a right model would reach about {number(floor)}, the noise floor. Conditions that "
            "the fit did not see; the whisker is a 90 % interval over them.",
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
    if results.diagnosis["verdict"]["effects"] in ([], ["unknown"]):  # nothing was added to the model
        rows = [(name, size, {**entry, "after": None}) for name, size, entry in rows]
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
        for y, (_, size, entry) in enumerate(rows):
            if largest[y] > CLIPPED_AT:
                ends = [
                    100 * value / size for value in (entry["before"], entry.get("after")) if value is not None
                ]
                told = ", then ".join(f"{value:.0f} %" for value in ends)  # its box may cover the second one
                axes.text(
                    CLIPPED_AT, y, f"{told} →", ha="right", va="center", fontsize=9,
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 4.0}, zorder=5,
                )  # fmt: skip
        end = CLIPPED_AT if max(largest) > CLIPPED_AT else None
        axes.set_yticks(range(len(rows)), [observable_words(name) for name, *_ in rows])
        axes.set(xlabel="gap (% of the typical measured value)", xlim=(0, end), ylim=(-0.6, len(rows) - 0.4))
        axes.grid(axis="y", visible=False)
        handles = [
            axes.plot([], [], "o", color=VERMILION, label="as it is, p < 0.05")[0],
            axes.plot([], [], "o", color=GREY, label="as it is, p ≥ 0.05")[0],
            axes.plot([], [], "|", color=INK, ms=13, mew=1.6, ls="", label="noise floor")[0],
        ]
        if any(entry.get("after") is not None for *_, entry in rows):
            handles += axes.plot([], [], "s", color=GREEN, mfc="white", mew=1.6, label="with the verdict")
        figure.legend(handles=handles, loc="outside upper left", ncols=2, fontsize=8.5)
        name, _, worst = rows[-1]
        info = results.observables.get(name)
        scale = scale_for([worst["before"]], info.unit if info else "1")
        return picture(
            figure,
            "by-observable",
            "Dots of the gap of each observable, before and after the verdict, with its noise floor.",
            f"Largest against its typical value: {observable_words(name)}, {number(float(scale(worst['before'])))} "
            f"{scale.unit}, where repeats alone would give "
            f"{number(float(scale(worst.get('noise_floor') or 0)))} {scale.unit}. Grey: by itself within noise.",
        )


def hypotheses_figure(diagnosis: Mapping[str, Any]) -> Picture | None:
    """Probabilities of the leading hypotheses; what nothing explains and no gap are always among them."""
    entries = sorted(diagnosis.get("hypotheses", []), key=lambda entry: -entry["probability"])
    if not entries:
        return None
    bars = [
        (effect_words(entry["effects"]), entry["probability"], entry["effects"])
        for rank, entry in enumerate(entries)
        if rank == 0
        or (rank < MOST and entry["probability"] >= LEAST)
        or entry["effects"] in ([], ["unknown"])
    ]
    if len(bars) < len(entries):
        rest = max(1.0 - sum(probability for _, probability, _ in bars), 0.0)
        bars.append((f"{len(entries) - len(bars)} others together", rest, None))
    bars.reverse()
    said = diagnosis["verdict"]["effects"]
    labels = [_wrapped(label) for label, *_ in bars]
    with canvas(0.9 + 0.17 * sum(1 + label.count("\n") for label in labels) + 0.17 * len(bars)) as (
        figure,
        axes,
    ):
        for y, (_, probability, effects) in enumerate(bars):
            colour = BLUE if effects == said or (effects and holds_the_pair(effects, said)) else GREY
            axes.barh(y, probability, color=colour, height=0.62)
            axes.annotate(
                percent(probability),
                (probability, y),
                (4, 0),
                textcoords="offset points",
                va="center",
                fontsize=9,
            )
        axes.set_yticks(range(len(bars)), labels)
        axes.set(xlabel="probability (1)", xlim=(0, 1.18), xticks=[0, 0.25, 0.5, 0.75, 1])
        axes.grid(axis="y", visible=False)
        return picture(
            figure,
            "hypotheses",
            "Bars of the probability of each hypothesis.",
            f"Which: {bars[-1][0]} leads with {percent(bars[-1][1])} of {len(entries)} hypotheses weighed. "
            "Blue: the verdict.",
        )


def _wrapped(text: str, width: int = 20) -> str:
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + len(word) >= width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)


def _first(*values: float | None) -> float | None:
    return next((value for value in values if value is not None), None)
