"""Posterior draws: marginals and pairs of a stage, and the ensembles' traces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.stats import gaussian_kde

from eaclutch.reporting.drawing import BLUE, GREY, SERIES, Picture, canvas, picture
from eaclutch.reporting.results import StageDraws
from eaclutch.reporting.words import Scale, number, scale_for, superscript

MOST = 6  # parameters of one corner plot; more could not be read


def corner_figure(stage: str, draws: StageDraws) -> Picture | None:
    """Histograms on the diagonal (grey line: the prior) under the parameter's name, pairs below it."""
    names = list(draws.posterior)[:MOST]
    if not names:
        return None
    scales = {name: axis_scale(draws.posterior[name], _unit(draws, name)) for name in names}
    flat = {name: scales[name](draws.posterior[name].ravel()) for name in names}
    n = len(names)
    points = np.linspace(0, len(flat[names[0]]) - 1, min(600, len(flat[names[0]]))).astype(int)
    with canvas(max(1.0 * n, 2.6), n, n) as (figure, grid):
        grid = np.atleast_2d(grid)
        for i, row in enumerate(names):
            for j, column in enumerate(names):
                axes = grid[i, j]
                if j > i:
                    axes.set_visible(False)
                    continue
                axes.grid(visible=False)
                axes.tick_params(labelsize=7, pad=2)
                axes.tick_params(axis="x", labelrotation=60)
                axes.locator_params(nbins=3)
                axes.ticklabel_format(useOffset=False, style="plain")
                if i == j:
                    prior = draws.prior.get(row)
                    _marginal(axes, flat[row], None if prior is None else scales[row](prior))
                    side = "right" if i == n - 1 and n > 1 else "left"  # the last has no room beyond it
                    axes.set_title(f"{_short(row)} ({scales[row].unit or 1})", fontsize=8, loc=side, pad=3)
                else:
                    axes.plot(
                        flat[column][points],
                        flat[row][points],
                        ".",
                        color=BLUE,
                        ms=1.6,
                        alpha=0.5,
                        rasterized=True,
                    )
                if i < n - 1:
                    axes.set_xticklabels([])
                if j > 0 or i == 0:
                    axes.set_yticklabels([])
        strongest = _strongest(flat)
        text = f"{stage.replace('_', ' ').capitalize()}: blue, posterior; grey line, prior."
        if strongest:
            first, second, correlation = strongest
            text += (
                f" Strongest correlation: {_short(first)} with {_short(second)}, {number(correlation, 2)}."
            )
        return picture(
            figure,
            f"corner-{stage}",
            f"Corner plot of the {stage} posterior: {', '.join(map(_short, names))}.",
            text,
        )


def axis_scale(values: np.ndarray, unit: str) -> Scale:
    """A prefix, or a power of ten before the unit, that leaves short numbers at the ticks."""
    scale = scale_for(values, unit)
    typical = float(np.median(np.abs(scale(values))))
    if not typical or 1e-2 <= typical < 1e4:
        return scale
    power = math.floor(math.log10(typical))
    return Scale(scale.factor / 10.0**power, f"10{superscript(power)} {scale.unit}".strip())


def trace_figure(stage: str, draws: StageDraws) -> Picture | None:
    """Every parameter's draws in the order of sampling, a colour an ensemble."""
    names = list(draws.posterior)[:MOST]
    if not names:
        return None
    with canvas(0.5 + 0.85 * len(names), rows=len(names)) as (figure, grid):
        for axes, name in zip(np.atleast_1d(grid), names, strict=True):
            scale = axis_scale(draws.posterior[name], _unit(draws, name))
            for chain, values in enumerate(scale(draws.posterior[name])):
                kept = np.linspace(0, len(values) - 1, min(150, len(values))).astype(int)
                axes.plot(kept, values[kept], color=SERIES[chain % len(SERIES)], lw=0.5, alpha=0.8)
            axes.set_title(f"{_short(name)} ({scale.unit or 1})", fontsize=8, loc="left", pad=3)
            axes.tick_params(labelsize=8)
            axes.ticklabel_format(axis="y", useOffset=False, style="plain")
        np.atleast_1d(grid)[-1].set_xlabel("draw, by step and walker (1)")
        chains = len(next(iter(draws.posterior.values())))
        return picture(
            figure,
            f"trace-{stage}",
            f"Traces of the {stage} posterior, {chains} ensembles.",
            f"{stage.replace('_', ' ').capitalize()}: {chains} independent ensembles; they should cover the same "
            "range.",
        )


def _marginal(axes: Any, values: np.ndarray, prior: np.ndarray | None) -> None:
    axes.hist(values, bins=24, density=True, color=BLUE, alpha=0.75)
    axes.set_yticks([])
    if prior is not None and np.ptp(prior) > 0:
        limits = axes.get_xlim()
        points = np.linspace(limits[0], limits[1], 80)
        axes.plot(points, gaussian_kde(prior)(points), color=GREY, lw=1.2)
        axes.set_xlim(limits)


def _strongest(flat: dict[str, np.ndarray]) -> tuple[str, str, float] | None:
    names = [name for name, values in flat.items() if np.std(values) > 0]
    if len(names) < 2:
        return None
    matrix = np.corrcoef([flat[name] for name in names])
    np.fill_diagonal(matrix, 0)
    i, j = np.unravel_index(np.argmax(np.abs(matrix)), matrix.shape)
    return names[i], names[j], float(matrix[i, j])


def _short(name: str) -> str:
    return name.replace("force_multiplier", "multiplier").replace("_", " ")


def _unit(draws: StageDraws, name: str) -> str:
    return draws.units.get(name, "1")
