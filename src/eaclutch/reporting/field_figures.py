"""Pictures of the finite-element study."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.tri import Triangulation

from eaclutch.records import FieldSolution
from eaclutch.reporting.drawing import BLUE, GREEN, GREY, VERMILION, Picture, canvas, picture


def excess_picture(conductor: pd.DataFrame) -> Picture:
    """Field solution over the analytic pressure, against the gap."""
    with canvas() as (figure, axes):
        looks = zip(conductor.groupby("film_permittivity"), "os", (BLUE, VERMILION), strict=False)
        for (permittivity, rows), marker, colour in looks:
            label = f"film permittivity {permittivity:g}"
            axes.plot(rows["gap_um"], 100 * rows["excess"], marker=marker, color=colour, label=label)
        axes.axhline(5, color=GREY, ls="--", lw=1)
        axes.text(1.0, 5.15, "the paper's 5 %", color=GREY, fontsize=9)
        axes.set(
            xscale="log", xlabel="air gap (µm)", ylabel="field solution above formula (%)", ylim=(0, None)
        )
        axes.legend(loc="center left")
        worst = conductor.loc[conductor["excess"].idxmax()]
        text = (
            f"The formula leaves out the field beside the electrodes. It is low by {100 * worst['excess']:.1f} % at "
            f"worst (film permittivity {worst['film_permittivity']:g}, {worst['gap_um']:g} µm); halving the mesh "
            f"changes the solution by {100 * conductor['mesh_change'].max():.2f} % at most."
        )
        return picture(figure, "excess", "Pressure by finite elements over the analytic one", text)


def insulator_picture(insulator: pd.DataFrame) -> Picture:
    """Gap voltage against the permittivity of an insulating substrate."""
    with canvas() as (figure, axes):
        axes.plot(
            insulator["substrate_permittivity"], 100 * insulator["gap_voltage_share"], "o-", color=GREEN
        )
        axes.axhline(50, color=GREY, ls="--", lw=1)
        axes.text(1.1, 47, "half the applied voltage", color=GREY, fontsize=9)
        axes.set(
            xscale="log",
            xlabel="substrate permittivity (1)",
            ylabel="gap voltage (% of applied)",
            ylim=(0, 53),
        )
        usual = insulator[insulator["substrate_permittivity"].between(3, 4)]
        text = (
            f"On insulators of permittivity 3-4 the gap holds {100 * usual['gap_voltage_share'].min():.1f}-"
            f"{100 * usual['gap_voltage_share'].max():.1f} % of the applied voltage (the paper: under 2 %)."
        )
        return picture(figure, "insulator", "Gap voltage on insulating substrates", text)


def field_picture(fields: Mapping[str, FieldSolution], film_thickness: float, gap: float) -> Picture:
    """Equipotentials near the inner electrode edges; the vertical axis is stretched."""
    with canvas(height=6, rows=2, columns=2, width=9) as (figure, axes):
        for axis, (name, field) in zip(np.ravel(axes), fields.items(), strict=True):
            near = (np.abs(field.x) < 0.6e-3) & (field.y > -40e-6) & (field.y < film_thickness + gap + 40e-6)
            mesh = Triangulation(1e3 * field.x[near], 1e6 * field.y[near])
            levels = np.linspace(0, field.potential.max(), 25)
            shown = axis.tricontourf(mesh, field.potential[near], levels=levels, cmap="cividis")
            axis.tricontour(mesh, field.potential[near], levels=levels, colors="white", linewidths=0.4)
            for height in (0, film_thickness * 1e6, (film_thickness + gap) * 1e6):
                axis.axhline(height, color="black", lw=0.6)
            axis.set_title(name, fontsize=10)
            axis.grid(False)
        figure.supxlabel("along the comb (mm)")
        figure.supylabel("height above the electrodes (µm)")
        figure.colorbar(shown, ax=axes, label="potential (V)")
        text = "Equipotentials between two electrodes; lines: electrodes, film surface, substrate. Heights stretched."
        return picture(figure, "fields", "Potential in the cross-section of the pad", text)
