"""A page of sections with text, pictures and tables: design maps, the paper's numbers, the field study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import jinja2
import pandas as pd

from eaclutch.reporting.drawing import Picture


@dataclass(frozen=True)
class Table:
    """Column heads and rows; numbers are shown with four digits."""

    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]


@dataclass(frozen=True)
class Section:
    """One heading with what stands under it."""

    title: str
    text: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    tables: Sequence[Table] = field(default_factory=tuple)


def table_of(frame: pd.DataFrame, heads: dict[str, str] | None = None) -> Table:
    """A data frame as a table of plain Python values."""
    names = [(heads or {}).get(str(name), str(name).replace("_", " ")) for name in frame.columns]
    return Table(names, frame.astype(object).to_numpy().tolist())


def render_study(title: str, lead: str, sections: Sequence[Section]) -> str:
    """The page as one HTML document that needs nothing else."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("eaclutch.reporting"), autoescape=True, undefined=jinja2.StrictUndefined
    )
    return environment.get_template("study.html.j2").render(title=title, lead=lead, sections=sections)
