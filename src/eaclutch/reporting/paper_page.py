"""The page of the paper's numbers beside ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
import pandas as pd

from eaclutch.reporting.drawing import BLUE, GREEN, GREY, VERMILION, Picture, canvas, picture
from eaclutch.reporting.study_page import Section, Table, render_study, table_of


class Compared(Protocol):
    """A printed number and ours."""

    @property
    def name(self) -> str: ...
    @property
    def published(self) -> float: ...
    @property
    def ours(self) -> float: ...
    @property
    def unit(self) -> str: ...
    @property
    def note(self) -> str: ...


def _claims_table(claims: Sequence[Compared]) -> Table:
    rows = []
    for claim in claims:
        ours = claim.ours if np.isfinite(claim.ours) else "cannot be had from this campaign"
        rows.append([claim.name, claim.published, ours, claim.unit, claim.note])
    return Table(["quantity", "printed", "ours", "unit", "what was assumed"], rows)


def literature_picture(times: Mapping[str, tuple[float, float]]) -> Picture:
    """Engagement against release time of clutches in the literature; what was not measured lies on the edge."""
    with canvas(height=4.2) as (figure, axes):
        for name, (engagement, release) in times.items():
            ours = name.startswith("Rauf")
            point = (
                engagement if np.isfinite(engagement) else 1.0,
                release if np.isfinite(release) else 100.0,
            )
            missing = not np.isfinite(engagement + release)
            axes.plot(
                *point,
                "s" if ours else "x" if missing else "o",
                color=VERMILION if ours else GREY if missing else BLUE,
            )
            axes.annotate(name, point, fontsize=6, xytext=(3, 2), textcoords="offset points")
        axes.set(
            xscale="log",
            yscale="log",
            xlabel="engagement time (s)",
            ylabel="release time (s)",
            xlim=(5e-6, 6),
        )
        text = (
            f"{len(times)} clutches; crosses at the right or upper edge: that time was not measured. "
            "Source: Rauf & Follmer (2025), Table S1."
        )
        return picture(figure, "literature", "Engagement and release times in the literature", text)


def exponent_picture(exponents: pd.DataFrame) -> Picture:
    """Exponent of force over voltage per drive frequency."""
    with canvas() as (figure, axes):
        axes.errorbar(
            exponents["frequency_hz"],
            exponents["exponent"],
            exponents["exponent_sd"],
            fmt="o",
            color=BLUE,
            capsize=3,
        )
        axes.axhline(1.605, color=GREY, ls="--", lw=1)
        axes.axhspan(1.605 - 0.309, 1.605 + 0.309, color=GREY, alpha=0.15, lw=0)
        axes.set(
            xscale="log", xlabel="drive frequency (Hz), DC at 0.1", ylabel="exponent n of force ~ V^n (1)"
        )
        text = f"Mean {exponents['exponent'].mean():.2f}; grey: the printed 1.605 ± 0.309."
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


def paper_page(
    groups: Mapping[str, Sequence[Compared]],
    exponents: pd.DataFrame,
    release: pd.DataFrame,
    multiplier: pd.DataFrame,
    times: Mapping[str, tuple[float, float]],
    campaign: str,
) -> str:
    """HTML: every printed number beside ours, with pictures."""
    sections = [Section(title, [], [], [_claims_table(claims)]) for title, claims in groups.items()]
    if len(exponents):
        sections.append(
            Section("Force over voltage", [], [exponent_picture(exponents)], [table_of(exponents)])
        )
    if len(release):
        sections.append(
            Section("Release over frequency", [], [release_picture(release)], [table_of(release)])
        )
    sections.append(Section("Release with and without the force multiplier", [], [], [table_of(multiplier)]))
    sections.append(Section("Times in the literature", [], [literature_picture(times)]))
    return render_study(
        "The paper's numbers", f"Campaign {campaign}; the paper's values beside ours.", sections
    )
