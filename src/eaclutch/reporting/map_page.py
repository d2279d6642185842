"""The page of design maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from eaclutch.records import FloatArray
from eaclutch.reporting.map_figures import AXIS, map_picture, probability_picture
from eaclutch.reporting.study_page import Section, render_study


class Drawn(Protocol):
    """What a map offers to be drawn."""

    @property
    def x_name(self) -> str: ...
    @property
    def y_name(self) -> str: ...
    @property
    def x(self) -> FloatArray: ...
    @property
    def y(self) -> FloatArray: ...
    @property
    def values(self) -> Mapping[str, FloatArray]: ...

    def quantiles(self, observable: str) -> FloatArray:
        """(3, y, x)."""

    def probability(self, limits: Mapping[str, tuple[float, float]]) -> FloatArray:
        """(y, x)."""


def map_page(
    maps: Sequence[tuple[str, Drawn]],
    limits: Mapping[str, tuple[float, float]],
    stated: Mapping[str, Any],
    design: Mapping[str, Any],
    campaign: str,
) -> str:
    """HTML: every (pad, map) with its probability of meeting the limits."""
    wanted = (
        f"release < {stated['release_ms']:g} ms, engagement < {stated['engagement_us']:g} µs and "
        f"capacity > {stated['capacity_n']:g} N"
    )
    sections = []
    for i, (pad, drawn) in enumerate(maps):
        names = (drawn.x_name, drawn.y_name)
        quantiles = {observable: drawn.quantiles(observable) for observable in drawn.values}
        pictures = [map_picture(f"map{i}", names, drawn.x, drawn.y, quantiles)]
        met = drawn.probability(limits)
        pictures.append(probability_picture(f"met{i}", names, drawn.x, drawn.y, met, wanted))
        title = f"{pad.replace('_', ' ')}: {AXIS[names[0]]} and {AXIS[names[1]]}"
        sections.append(Section(title, [], pictures))
    fixed = ", ".join(f"{AXIS.get(name, name.replace('_', ' '))} {value:g}" for name, value in design.items())
    lead = f"Campaign {campaign}. What is not varied stays at: {fixed}."
    return render_study("Design maps", lead, sections)
