"""The page of the paper's numbers beside ours."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd

from eaclutch.reporting.paper_figures import (
    bandwidth_picture,
    exponent_picture,
    literature_picture,
    multiplier_picture,
    release_picture,
    step_picture,
)
from eaclutch.reporting.study_page import Section, Table, render_study, table_of
from eaclutch.reporting.words import unit_words

LEADS = {
    "From the calibrated model": (
        "At the medians of this campaign's posteriors, by our solver: another calibration than the paper's, so these "
        "numbers need not agree. The same numbers with the paper's parameters stand under the next heading.",
    ),
    "With the paper's parameters": (
        "Slopes by the choices of the paper's released scripts: the tip starts at one minus the start ratio, the run "
        "ends at the first zero of the velocity, the contact lies on the electrodes' area (docs/solver.md).",
    ),
}
EXPONENTS = {
    "frequency_hz": "drive frequency (Hz)",
    "exponent": "exponent of the largest force (1)",
    "exponent_sd": "standard error (1)",
    "voltages": "voltages",
}
RELEASE = {
    "frequency_hz": "drive frequency (Hz)",
    "release_time_10_s": "10 % release time (ms)",
    "release_time_10_s_sem": "standard error (ms)",
    "release_time_10_s_runs": "runs",
    "release_time_90_s": "90 % release time (ms)",
    "release_time_90_s_sem": "standard error (ms)",
    "release_time_90_s_runs": "runs",
}
MULTIPLIER = {
    "voltage_v": "voltage (V)",
    "release_ms_with_multiplier": "release, calibrated multiplier (ms)",
    "release_ms_without_multiplier": "release, multiplier 1 (ms)",
    "change_percent": "change (%)",
}


@dataclass(frozen=True)
class PaperFigures:
    """What the pictures show: tables as the studies make them; ``corner`` [Hz]: where the force has halved."""

    force_exponents: pd.DataFrame
    capacity_exponents: pd.DataFrame
    release: pd.DataFrame
    multiplier: pd.DataFrame
    bandwidth: pd.DataFrame
    corner: float
    step: pd.DataFrame


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
        unit = unit_words(claim.unit) or "1"
        rows.append([_with_micro(claim.name), claim.published, ours, unit, _with_micro(claim.note)])
    return Table(["quantity", "printed", "ours", "unit", "what was assumed, why it differs"], rows)


def _with_micro(text: str) -> str:
    """``um`` and ``us`` as one writes them, squares of centimetres too."""
    return re.sub(r"\bu(?=[ms]\b)", "µ", text).replace("cm2", "cm²")


def paper_page(
    groups: Mapping[str, Sequence[Compared]],
    figures: PaperFigures,
    times: Mapping[str, tuple[float, float]],
    campaign: str,
) -> str:
    """HTML: every printed number beside ours, with pictures."""
    sections = [
        Section(title, LEADS.get(title, ()), [], [_claims_table(claims)]) for title, claims in groups.items()
    ]
    if len(figures.capacity_exponents):
        drawn = exponent_picture(figures.force_exponents, figures.capacity_exponents)
        sections.append(
            Section("Force over voltage", [], [drawn], [table_of(figures.force_exponents, EXPONENTS)])
        )
    if len(figures.release):
        shown = figures.release.assign(
            **{name: 1e3 * figures.release[name] for name in RELEASE if name.endswith(("_s", "_sem"))}
        )
        sections.append(
            Section(
                "Release over frequency", [], [release_picture(figures.release)], [table_of(shown, RELEASE)]
            )
        )
    sections.append(
        Section(
            "Release with and without the force multiplier",
            [],
            [multiplier_picture(figures.multiplier)],
            [table_of(figures.multiplier, MULTIPLIER)],
        )
    )
    responses = [bandwidth_picture(figures.bandwidth, figures.corner), step_picture(figures.step)]
    sections.append(Section("Bandwidth and step response", [], responses))
    sections.append(Section("Times in the literature", [], [literature_picture(times)]))
    return render_study(
        "The paper's numbers", f"Campaign {campaign}; the paper's values beside ours.", sections
    )
