"""Figures of the finite-element study."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from eaclutch.records import FieldSolution


def pressure_figure(conductor: pd.DataFrame, insulator: pd.DataFrame) -> Figure:
    """Left: excess of the field solution over the formula. Right: insulating substrates."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for (permittivity, rows), marker in zip(conductor.groupby("film_permittivity"), "os", strict=False):
        left.plot(
            rows["gap_um"], 100 * rows["excess"], marker=marker, label=f"film permittivity {permittivity:g}"
        )
    left.axhline(5, color="0.5", ls="--", lw=1)
    left.text(1.0, 5.1, "the paper's 5 %", color="0.35", fontsize=9)
    left.set(xscale="log", xlabel="air gap (µm)", ylabel="field solution above formula (%)", ylim=(0, None))
    left.legend(frameon=False)
    right.plot(insulator["substrate_permittivity"], 100 * insulator["gap_voltage_share"], "o-", color="C2")
    right.axhline(50, color="0.5", ls="--", lw=1)
    right.text(1.1, 46, "half the applied voltage", color="0.35", fontsize=9)
    right.set(
        xscale="log",
        xlabel="substrate permittivity",
        ylabel="gap voltage (% of the applied one)",
        ylim=(0, 53),
    )
    return figure


def field_figure(fields: Mapping[str, FieldSolution], film_thickness: float, gap: float) -> Figure:
    """Equipotentials near the inner electrode edges; the vertical axis is stretched."""
    figure, axes = plt.subplots(2, 2, figsize=(10, 6), layout="constrained", sharex=True, sharey=True)
    for axis, (name, field) in zip(axes.ravel(), fields.items(), strict=True):
        near = (np.abs(field.x) < 0.6e-3) & (field.y > -40e-6) & (field.y < film_thickness + gap + 40e-6)
        mesh = Triangulation(1e3 * field.x[near], 1e6 * field.y[near])
        levels = np.linspace(0, field.potential.max(), 25)
        shown = axis.tricontourf(mesh, field.potential[near], levels=levels, cmap="cividis")
        axis.tricontour(mesh, field.potential[near], levels=levels, colors="white", linewidths=0.4)
        for height in (0, film_thickness * 1e6, (film_thickness + gap) * 1e6):
            axis.axhline(height, color="black", lw=0.6)
        axis.set_title(name, fontsize=10)
    figure.supxlabel("along the comb (mm)")
    figure.supylabel("height above the electrodes (µm)")
    figure.colorbar(shown, ax=axes, label="potential (V)")
    return figure
