"""Predicted against measured, one picture an observable."""

from __future__ import annotations

import numpy as np

from eaclutch.reporting.drawing import BLUE, GREY, INK, MARKERS, SERIES, Picture, canvas, picture
from eaclutch.reporting.results import Results
from eaclutch.reporting.words import number, observable_words, percent, scale_for

MOST = 300  # points of a picture; the caption counts all


def prediction_figures(results: Results) -> list[Picture]:
    """A picture for each observable that was both measured and predicted."""
    order = [name for name in results.observables if name in set(results.predictions["observable"])]
    drawn = [_prediction(results, name, index) for index, name in enumerate(order)]
    return [item for item in drawn if item is not None]


def _prediction(results: Results, name: str, index: int) -> Picture | None:
    table = results.predicted(name)
    if table.empty:
        return None
    statuses = results.predictions[results.predictions["observable"] == name].drop_duplicates("run")["status"]
    table = table.merge(results.runs[["run", "session"]], on="run")
    runs = len(table)
    inside = float(np.mean((table["measured"] >= table["q05"]) & (table["measured"] <= table["q95"])))
    offset = float(np.median(table["median"] - table["measured"]))
    table = table.iloc[np.unique(np.linspace(0, runs - 1, min(runs, MOST)).astype(int))]
    scale = scale_for(table["measured"], results.observables[name].unit)
    measured, median = scale(table["measured"]), scale(table["median"])
    low, high = scale(table["q05"]), scale(table["q95"])
    with canvas(3.7) as (figure, axes):
        for i, session in enumerate(sorted(table["session"].unique())):
            chosen = (table["session"] == session).to_numpy()
            axes.errorbar(
                measured[chosen], median[chosen],
                xerr=scale(table["measured_sd"].fillna(0))[chosen],
                yerr=np.maximum(np.stack([median - low, high - median])[:, chosen], 0),
                fmt=MARKERS[i % len(MARKERS)], color=SERIES[i % len(SERIES)], ms=4, lw=0.7, alpha=0.75,
                label=session or "?",
            )  # fmt: skip
        shown = np.concatenate([measured, low, high])
        ends = np.nanquantile(shown, [0.005, 0.995])
        ends = ends + np.array([-0.06, 0.06]) * max(ends[1] - ends[0], 1e-12)
        axes.plot(ends, ends, color=INK, lw=1, ls="--")
        unit = scale.unit or "1"
        axes.set(xlim=ends, ylim=ends, xlabel=f"measured ({unit})", ylabel=f"predicted ({unit})")
        axes.locator_params(nbins=5)
        axes.set_title(observable_words(name), loc="left", fontsize=11)
        figure.legend(loc="outside lower left", ncols=4, fontsize=8.5, handletextpad=0.1)
        strange = int((statuses != "ok").sum())
        text = (
            f"{runs} runs; {percent(inside)} of the measured values lie in the 90\u00a0% interval; predicted less "
            f"measured {number(float(scale(offset)), 2)} {scale.unit}".rstrip()
            + " in the median."
        )
        if runs > len(table):
            text += f" Drawn: {len(table)} of them."
        if strange:
            kinds = ", ".join(sorted(set(statuses) - {"ok"})).replace("_", " ")
            text += f" {strange} more without a number from the model ({kinds})."
        return picture(
            figure,
            f"prediction-{index}",
            f"Predicted against measured {observable_words(name)}, by session.",
            text,
        )


def coverage_figure(results: Results) -> Picture | None:
    """Share of measured values in their 90 % interval, by observable."""
    table = results.predicted()
    if not len(table):
        return None
    inside = (table["measured"] >= table["q05"]) & (table["measured"] <= table["q95"])
    shares = inside.groupby(table["observable"]).agg(["mean", "size"]).sort_values("mean")
    with canvas(0.9 + 0.27 * len(shares)) as (figure, axes):
        y = np.arange(len(shares))
        axes.hlines(y, 0, shares["mean"], color=GREY, lw=1)
        axes.plot(shares["mean"], y, "o", color=BLUE)
        axes.axvline(0.9, color=INK, ls="--", lw=1.2)
        axes.set_yticks(y, [observable_words(name) for name in shares.index])
        axes.set(xlabel="share inside the 90 % interval (1)", xlim=(0, 1.02))
        axes.grid(axis="y", visible=False)
        return picture(
            figure,
            "coverage",
            "Dots: for each observable the share of measured values inside the predicted 90 % interval.",
            f"90 % would be right; {observable_words(shares.index[0])} has {percent(shares['mean'].iloc[0])}, "
            f"{observable_words(shares.index[-1])} {percent(shares['mean'].iloc[-1])}.",
        )
