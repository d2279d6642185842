"""A page of sections with text, pictures and tables: design maps, the paper's numbers, the field study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from eaclutch.reporting.drawing import Picture
from eaclutch.reporting.templating import environment


@dataclass(frozen=True)
class Table:
    """Column heads with units, and rows; numbers are shown with four digits."""

    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]


@dataclass(frozen=True)
class Section:
    """One heading with what stands under it."""

    title: str
    text: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    tables: Sequence[Table] = field(default_factory=tuple)


def table_of(frame: pd.DataFrame, heads: Mapping[str, str]) -> Table:
    """The frame's columns that ``heads`` names, under those heads, as plain Python values."""
    shown = frame[list(heads)]
    return Table(list(heads.values()), shown.astype(object).to_numpy().tolist())


def render_study(title: str, lead: str, sections: Sequence[Section]) -> str:
    """The page as one HTML document that needs nothing else."""
    return environment().get_template("study.html.j2").render(title=title, lead=lead, sections=sections)
