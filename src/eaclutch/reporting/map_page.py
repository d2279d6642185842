"""The page of design maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from eaclutch.records import FloatArray
from eaclutch.reporting.map_figures import AXIS, axis_words, level_words, map_pictures, probability_picture
from eaclutch.reporting.study_page import Section, Table, render_study


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


class Stated(Protocol):
    """A printed statement on the maps and what these say."""

    @property
    def printed(self) -> str: ...
    @property
    def ours(self) -> str: ...
    @property
    def holds(self) -> bool: ...
    @property
    def why(self) -> str: ...


def map_page(
    maps: Sequence[tuple[str, Drawn]],
    limits: Mapping[str, tuple[float, float]],
    stated: Mapping[str, Any],
    design: Mapping[str, Any],
    campaign: str,
    trends: Sequence[Stated] = (),
) -> str:
    """HTML: the printed trends beside these, then every (pad, map) with its probability of meeting the limits."""
    wanted = (
        f"release < {stated['release_ms']:g} ms, engagement < {stated['engagement_us']:g} µs and "
        f"capacity > {stated['capacity_n']:g} N"
    )
    sections = []
    for i, (pad, drawn) in enumerate(maps):
        names = (drawn.x_name, drawn.y_name)
        quantiles = {observable: drawn.quantiles(observable) for observable in drawn.values}
        pictures = map_pictures(f"map{i}", names, drawn.x, drawn.y, quantiles)
        met = drawn.probability(limits)
        pictures.append(probability_picture(f"met{i}", names, drawn.x, drawn.y, met, wanted))
        kind = pad.replace("_", " ").capitalize()
        sections.append(
            Section(f"{kind} pad: {axis_words(names[0])} and {axis_words(names[1])}", [], pictures)
        )
    if trends:
        sections.insert(0, Section("The paper's trends", [], [], [_trend_table(trends)]))
    fixed = ", ".join(
        level_words(name, value) if name in AXIS else f"{name.replace('_', ' ')} {value:g}"
        for name, value in design.items()
    )
    lead = (
        f"Campaign {campaign}. What is not varied stays at: {fixed}. Release maps are speckled where one more half "
        "swing of the load cell just happens or just does not."
    )
    return render_study("Design maps", lead, sections)


def _trend_table(trends: Sequence[Stated]) -> Table:
    rows = []
    for trend in trends:
        judged = ("holds", "") if trend.holds else ("does not hold", f" {trend.why}")
        rows.append([trend.printed, judged[0], trend.ours + judged[1]])
    return Table(["the paper says", "here", "interdigitated pad of this campaign"], rows)
