"""What was measured besides the runs: gaps from capacitance, permittivity spectra; and the runs at a glance."""

from __future__ import annotations

import numpy as np

from eaclutch.reporting.drawing import MARKERS, SERIES, Picture, canvas, picture
from eaclutch.reporting.results import Results
from eaclutch.reporting.words import number, observable_words, scale_for


def bench_figures(results: Results) -> list[Picture]:
    """Pictures of the side benches that have data, and the two leading observables against voltage."""
    drawn = [_gap(results), _spectra(results)]
    drawn += [_against_voltage(results, name) for name in ("shear_capacity_n", "release_time_90_s")]
    return [item for item in drawn if item is not None]


def _gap(results: Results) -> Picture | None:
    table = results.gap
    if not len(table):
        return None
    used = (
        table["used"].astype(str).str.lower() == "true"
        if "used" in table
        else np.ones(len(table), dtype=bool)
    )
    with canvas(3.2) as (figure, axes):
        for i, (width, rows) in enumerate(table[used].groupby("width_mm")):
            axes.plot(
                rows["force_n"], rows["gap_um"], MARKERS[i % len(MARKERS)],
                color=SERIES[i % len(SERIES)], ms=3, alpha=0.6, label=f"{width:g} mm",
            )  # fmt: skip
        axes.set(xlabel="normal force (N)", ylabel="mean gap (µm)")
        axes.legend(title="width", ncols=2)
        return picture(
            figure,
            "gap",
            "Mean gap from capacitance against normal force, by substrate width.",
            f"{int(used.sum())} of {len(table)} readings; gaps from {number(float(table['gap_um'][used].min()))} "
            f"to {number(float(table['gap_um'][used].max()))} µm. Which of them the contact is fitted to stands "
            "under the parameters.",
        )


def _spectra(results: Results) -> Picture | None:
    table = results.spectra
    if not len(table):
        return None
    with canvas(3.2) as (figure, axes):
        for i, (source, rows) in enumerate(table.groupby("source")):
            rows = rows.sort_values("frequency_hz")
            axes.plot(
                rows["frequency_hz"], rows["relative_permittivity"], MARKERS[i % len(MARKERS)] + "-",
                color=SERIES[i % len(SERIES)], ms=3.5, lw=0.8, label=str(source).replace("_", " "),
            )  # fmt: skip
        axes.set(xscale="log", xlabel="frequency (Hz)", ylabel="relative permittivity (1)")
        axes.legend()
        return picture(
            figure,
            "spectra",
            "Relative permittivity against frequency, by source.",
            f"{len(table)} points of {table['source'].nunique()} sources, "
            f"{number(float(table['relative_permittivity'].min()))} to "
            f"{number(float(table['relative_permittivity'].max()))}.",
        )


def _against_voltage(results: Results, name: str) -> Picture | None:
    runs = results.runs
    runs = (
        runs[(runs["usable"].astype(str).str.lower() == "true") & runs[name].notna()]
        if name in runs
        else runs[:0]
    )
    if runs.empty:
        return None
    scale = scale_for(runs[name], results.observables[name].unit)
    with canvas(3.2) as (figure, axes):
        for i, (session, rows) in enumerate(runs.groupby("session")):
            axes.errorbar(
                rows["voltage_v"] + 2.0 * i, scale(rows[name]), yerr=scale(rows[f"{name}_sd"].fillna(0)),
                fmt=MARKERS[i % len(MARKERS)], color=SERIES[i % len(SERIES)], ms=4, lw=0.8, alpha=0.7,
                label=str(session),
            )  # fmt: skip
        axes.set(xlabel="voltage (V)", ylabel=f"{observable_words(name)} ({scale.unit})", ylim=(0, None))
        figure.legend(loc="outside lower left", ncols=4, fontsize=8.5, handletextpad=0.1)
        return picture(
            figure,
            f"measured-{name.replace('_', '-')}",
            f"Measured {observable_words(name)} against voltage, by session.",
            f"{len(runs)} runs; median {number(float(np.median(scale(runs[name]))))} {scale.unit}. "
            "Sessions are drawn side by side.",
        )
