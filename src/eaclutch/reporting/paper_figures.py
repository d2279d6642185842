"""Pictures of the paper's numbers beside ours."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
import pandas as pd

from eaclutch.reporting.drawing import BLUE, GREEN, GREY, VERMILION, Picture, canvas, picture

CHARACTER = 0.075  # decades that a letter takes in the picture of the literature


def literature_picture(times: Mapping[str, tuple[float, float]]) -> Picture:
    """Engagement against release time of clutches in the literature; what was not measured lies on the edge."""
    with canvas(height=4.2) as (figure, axes):
        points = {
            name: (np.nan_to_num(engagement, nan=1.0), np.nan_to_num(release, nan=100.0))
            for name, (engagement, release) in times.items()
        }
        taken = [_box(*point, 0.1) for point in points.values()]
        for name, point in points.items():
            missing = not np.isfinite(sum(times[name]))
            look = ("s", VERMILION) if name.startswith("Rauf") else ("x", GREY) if missing else ("o", BLUE)
            axes.plot(*point, look[0], color=look[1])
            length = CHARACTER * len(name)
            for side, up in itertools.product((1, -1), (0.0, 0.15, -0.15, 0.3, -0.3)):
                middle = np.log10(point[0]) + side * (0.16 + length / 2)
                box = (middle, np.log10(point[1]) + up, length / 2, 0.06)
                if not any(
                    abs(box[0] - b[0]) < box[2] + b[2] and abs(box[1] - b[1]) < box[3] + b[3] for b in taken
                ):
                    break
            taken.append(box)
            axes.text(10 ** box[0], 10 ** box[1], name, fontsize=6.5, ha="center", va="center")
        axes.set(
            xscale="log",
            yscale="log",
            xlabel="engagement time (s)",
            ylabel="release time (s)",
            xlim=(5e-6, 20),
        )
        text = (
            f"{len(times)} clutches; crosses at the right or upper edge: that time was not measured. "
            "Source: Rauf & Follmer (2025), Table S1."
        )
        return picture(figure, "literature", "Engagement and release times in the literature", text)


def _box(x: float, y: float, half: float) -> tuple[float, float, float, float]:
    """Middle and half sizes of a mark in decades."""
    return float(np.log10(x)), float(np.log10(y)), half, 0.05


def exponent_picture(largest: pd.DataFrame, capacity: pd.DataFrame) -> Picture:
    """Exponent of force over voltage per drive frequency: of the largest force as in the paper, and of the capacity."""
    with canvas() as (figure, axes):
        looks = (
            (largest, 0.96, "o", BLUE, "largest force, as the paper"),
            (capacity, 1.04, "s", VERMILION, "capacity, less the friction before"),
        )
        for exponents, aside, marker, colour, label in looks:
            axes.errorbar(
                exponents["frequency_hz"] * aside, exponents["exponent"], exponents["exponent_sd"],
                fmt=marker, color=colour, capsize=3, label=label,
            )  # fmt: skip
        axes.axhline(1.605, color=GREY, ls="--", lw=1)
        axes.axhspan(1.605 - 0.309, 1.605 + 0.309, color=GREY, alpha=0.15, lw=0)
        axes.set(
            xscale="log", xlabel="drive frequency (Hz), DC at 0.1", ylabel="exponent n of force ~ V^n (1)"
        )
        figure.legend(loc="outside upper left", fontsize=8.5)
        text = (
            f"Means {largest['exponent'].mean():.2f} of the largest force, {capacity['exponent'].mean():.2f} of the "
            "capacity; grey: the printed 1.605 ± 0.309."
        )
        return picture(figure, "exponents", "Exponent of force over voltage per drive frequency", text)


def release_picture(release: pd.DataFrame) -> Picture:
    """10 % and 90 % release times against the drive frequency."""
    with canvas() as (figure, axes):
        for name, label, colour in (
            ("release_time_90_s", "90 %", VERMILION),
            ("release_time_10_s", "10 %", GREEN),
        ):
            axes.errorbar(
                release["frequency_hz"], 1e3 * release[name], 1e3 * release[f"{name}_sem"],
                fmt="o-", color=colour, capsize=3, label=label,
            )  # fmt: skip
        axes.set(
            xscale="log", xlabel="drive frequency (Hz), DC at 0.1", ylabel="release time (ms)", ylim=(0, None)
        )
        axes.legend()
        fastest = release.loc[release["release_time_90_s"].idxmin()]
        text = (
            f"2 mm strips, preload < 0.25 N. Fastest 90 % release: {1e3 * fastest['release_time_90_s']:.2f} ms at "
            f"{fastest['frequency_hz']:g} Hz. Bars: standard error."
        )
        return picture(figure, "release", "10 % and 90 % release times over drive frequency", text)


def multiplier_picture(multiplier: pd.DataFrame) -> Picture:
    """Median release time over voltage with the calibrated force multiplier and with it at 1."""
    with canvas() as (figure, axes):
        for column, label, colour, marker in (
            ("release_ms_with_multiplier", "calibrated multiplier", BLUE, "o"),
            ("release_ms_without_multiplier", "multiplier 1", VERMILION, "s"),
        ):
            axes.plot(multiplier["voltage_v"], multiplier[column], f"{marker}-", color=colour, label=label)
        axes.set(xlabel="voltage (V)", ylabel="predicted 90 % release time (ms)")
        axes.set_ylim(0, 1.1 * axes.get_ylim()[1])
        axes.legend()
        largest = multiplier.loc[multiplier["change_percent"].abs().idxmax()]
        text = (
            f"The multiplier changes the release time by {largest['change_percent']:+.1f} % at most "
            f"({largest['voltage_v']:g} V). The paper: similar trends with and without it."
        )
        return picture(
            figure, "multiplier", "Release time over voltage with and without the multiplier", text
        )


def bandwidth_picture(response: pd.DataFrame, corner: float) -> Picture:
    """Largest force over the drive frequency, with the corner."""
    with canvas() as (figure, axes):
        axes.plot(response["frequency_hz"], response["force_n"], color=BLUE)
        axes.axhline(response["force_n"].iloc[0] / 2, color=GREY, ls="--", lw=1)
        axes.axvline(13.3e3, color=GREY, ls=":", lw=1.2)
        axes.set(xscale="log", xlabel="drive frequency (Hz)", ylabel="largest force (N)", ylim=(0, None))
        text = (
            f"Falls to a half (dashed) at {corner / 1e3:.1f} kHz with this campaign's calibration; dotted: the printed "
            "13.3 kHz."
        )
        return picture(figure, "bandwidth", "Largest force over the drive frequency", text)


def step_picture(response: pd.DataFrame) -> Picture:
    """Polarisation after a step of the voltage."""
    with canvas() as (figure, axes):
        axes.plot(1e6 * response["time_s"], 100 * response["share"], color=BLUE)
        axes.axvline(100, color=GREY, ls=":", lw=1.2)
        axes.axhline(93, color=GREY, ls="--", lw=1)
        axes.set(
            xscale="log", xlabel="time after the step (µs)", ylabel="polarisation (% of final)", ylim=(0, 102)
        )
        at = float(np.interp(1e-4, response["time_s"], response["share"]))
        text = f"{100 * at:.1f} % after 100 µs with the printed Cole-Cole parameters; the paper: 93 %."
        return picture(figure, "step", "Polarisation after a step of the voltage", text)
