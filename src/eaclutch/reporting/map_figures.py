"""Pictures of design maps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.records import FloatArray
from eaclutch.reporting.drawing import Picture, canvas, picture
from eaclutch.reporting.words import short

SHOWN = {
    "engagement_time_s": ("engagement (µs)", 1e6),
    "release_time_90_s": ("release (ms)", 1e3),
    "shear_capacity_n": ("shear capacity (N)", 1.0),
}
AXIS = {
    "voltage_v": "voltage (V)",
    "frequency_hz": "drive frequency (Hz)",
    "width_mm": "substrate width (mm)",
    "preload_n": "preload (N)",
    "film_thickness_um": "film thickness (µm)",
    "overlap_length_mm": "overlap length (mm)",
    "drive_time_us": "rise and fall time (µs)",
    "electrodes": "electrodes (1)",
}


def axis_words(name: str) -> str:
    """An axis without its unit."""
    return AXIS[name].partition(" (")[0]


def level_words(name: str, level: float) -> str:
    """``film thickness 24 µm``."""
    unit = AXIS[name].partition(" (")[2].rstrip(")")
    return f"{axis_words(name)} {short(level, 3)} {unit}".strip()


def map_pictures(
    name: str, axes_of: tuple[str, str], x: FloatArray, y: FloatArray, quantiles: Mapping[str, FloatArray]
) -> list[Picture]:
    """A picture an observable: medians as colours with contour lines; grey: no value in most draws.

    ``quantiles[observable]``: (3, y, x), the 5, 50 and 95 % levels. The caption states the half-width of the band.
    """
    pictures = []
    for observable, (label, scale) in SHOWN.items():
        low, median, high = quantiles[observable] * scale
        with canvas(height=3.4) as (figure, panel):
            panel.grid(False)
            panel.set_facecolor("#e4e7ec")
            text = f"{label.partition(' (')[0].capitalize()}: no value here."
            if np.isfinite(median).any():
                shown = panel.pcolormesh(x, y, median, cmap="cividis", shading="nearest", rasterized=True)
                figure.colorbar(shown, ax=panel, label=label)
                lines = panel.contour(x, y, median, levels=6, colors="white", linewidths=0.7)
                panel.clabel(lines, fontsize=7, fmt="%.3g")
                band = 100 * np.nanmedian((high - low) / (2 * median))
                text = (
                    f"{label.partition(' (')[0].capitalize()}, median; the 90 % band is typically ±{band:.0f} % wide. "
                    "Grey: no value in most draws."
                )
            panel.set(xlabel=AXIS[axes_of[0]], ylabel=AXIS[axes_of[1]])
            alt = f"Map of {label} over {axis_words(axes_of[0])} and {axis_words(axes_of[1])}"
            pictures.append(picture(figure, f"{name}-{observable.replace('_', '-')}", alt, text))
    return pictures


def probability_picture(
    name: str, axes_of: tuple[str, str], x: FloatArray, y: FloatArray, probability: FloatArray, limits: str
) -> Picture:
    """Probability over the map that a design meets the stated limits."""
    with canvas(height=3.4) as (figure, panel):
        panel.grid(False)
        shown = panel.pcolormesh(
            x, y, probability, cmap="cividis", shading="nearest", vmin=0, vmax=1, rasterized=True
        )
        figure.colorbar(shown, ax=panel, label="probability (1)")
        panel.set(xlabel=AXIS[axes_of[0]], ylabel=AXIS[axes_of[1]])
        best = np.unravel_index(np.argmax(probability), probability.shape)
        text = (
            f"Probability that {limits}. Largest: {probability[best]:.2f} at "
            f"{level_words(axes_of[0], x[best[1]])}, {level_words(axes_of[1], y[best[0]])}."
        )
        return picture(
            figure,
            name,
            f"Probability of meeting the limits over {axis_words(axes_of[0])} and {axis_words(axes_of[1])}",
            text,
        )
