"""The paper's statements on its design maps (its Fig. 10), each beside what the campaign's own maps say.

Source: Rauf & Follmer (2025), Sec. 5, doi:10.1016/j.eml.2025.102382.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from eaclutch.records import FloatArray
from eaclutch.studies.sweep import DesignMap

RELEASE, ENGAGEMENT = "release_time_90_s", "engagement_time_s"
LARGE = 1.2  # largest over smallest along an axis; less is a small effect
DEEP = 1.01  # an extremum stands out of its neighbourhood by this factor
Profiles = Mapping[tuple[str, str], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class Trend:
    """A printed statement, what ours says with its numbers, whether it holds, and why not."""

    printed: str
    ours: str
    holds: bool
    why: str = ""


def map_trends(maps: Sequence[DesignMap], defaults: Mapping[str, float]) -> list[Trend]:
    """The statements that these maps of one pad can be asked about; ``defaults``: the design's level of each axis."""
    profiles = _profiles(maps, defaults)
    checks: list[Callable[[Profiles], Trend | None]] = [_width_first, _voltage, _engagement, _thickness]
    found = [check(profiles) for check in checks]
    return [trend for trend in found if trend is not None]


def _profiles(maps: Sequence[DesignMap], defaults: Mapping[str, float]) -> Profiles:
    """(axis, observable): levels and medians along that axis, the other axis at the design's level."""
    found: dict[tuple[str, str], tuple[FloatArray, FloatArray]] = {}
    for drawn in maps:
        for name in drawn.values:
            median = drawn.quantiles(name)[1]
            if drawn.x_name in defaults:
                found[drawn.y_name, name] = drawn.y, median[:, _nearest(drawn.x, defaults[drawn.x_name])]
            if drawn.y_name in defaults:
                found.setdefault(
                    (drawn.x_name, name), (drawn.x, median[_nearest(drawn.y, defaults[drawn.y_name])])
                )
    return {key: found[key] for key in found if np.isfinite(found[key][1]).sum() >= 3}


def _nearest(levels: FloatArray, level: float) -> int:
    return int(np.argmin(np.abs(levels - level)))


def _spans(profiles: Profiles, observable: str) -> dict[str, float]:
    """Largest over smallest median along each axis."""
    return {
        axis: float(np.nanmax(values) / np.nanmin(values))
        for (axis, name), (_, values) in profiles.items()
        if name == observable
    }


def _told(spans: Mapping[str, float], words: Mapping[str, str]) -> str:
    ordered = sorted(spans, key=lambda axis: -spans[axis])
    return ", ".join(f"{words.get(axis, axis)} by a factor of {spans[axis]:.2f}" for axis in ordered)


WORDS = {
    "voltage_v": "voltage",
    "width_mm": "substrate width",
    "film_thickness_um": "film thickness",
    "overlap_length_mm": "substrate length",
    "drive_time_us": "rise and fall time",
}


def _width_first(profiles: Profiles) -> Trend | None:
    spans = _spans(profiles, RELEASE)
    if "width_mm" not in spans or len(spans) < 2:
        return None
    return Trend(
        "The substrate's width matters most for the release time, then voltage and film thickness.",
        f"Over the range of each axis the release time changes: {_told(spans, WORDS)}.",
        spans["width_mm"] == max(spans.values()),
        "The ranges of the axes decide the order: they stand in the config (sweep.ranges).",
    )


def _voltage(profiles: Profiles) -> Trend | None:
    if ("voltage_v", RELEASE) not in profiles:
        return None
    levels, values = (
        array[np.isfinite(profiles["voltage_v", RELEASE][1])] for array in profiles["voltage_v", RELEASE]
    )
    return Trend(
        "A higher voltage releases faster.",
        f"{1e3 * values[0]:.2f} ms at {levels[0]:.0f} V, {1e3 * values[-1]:.2f} ms at {levels[-1]:.0f} V.",
        bool(values[-1] < values[0]),
    )


def _engagement(profiles: Profiles) -> Trend | None:
    spans = _spans(profiles, ENGAGEMENT)
    if not {"drive_time_us", "voltage_v"} <= set(spans):
        return None
    small = [spans[axis] for axis in ("film_thickness_um", "overlap_length_mm") if axis in spans]
    return Trend(
        "Rise time, width and voltage drive the engagement time; film thickness and length do much less.",
        f"Over the range of each axis the engagement time changes: {_told(spans, WORDS)}.",
        min(spans["drive_time_us"], spans.get("width_mm", np.inf)) > max([*small, 1.0])
        and spans["voltage_v"] > LARGE,
        "Voltage hardly matters here: engagement ends when the gap has done a fixed small part of its way, and way "
        "and pull grow together. The printed slope, -0.0012 µs/V, is as small.",
    )


def _thickness(profiles: Profiles) -> Trend | None:
    if ("film_thickness_um", RELEASE) not in profiles:
        return None
    levels, values = profiles["film_thickness_um", RELEASE]
    at = int(np.nanargmin(values))
    ends = [values[np.isfinite(values)][0], values[np.isfinite(values)][-1]]
    inside = min(ends) > DEEP * values[at]
    return Trend(
        "The release time has a local minimum over the film's thickness.",
        f"Smallest, {1e3 * values[at]:.3f} ms, at {levels[at]:.0f} µm; {1e3 * ends[0]:.3f} and {1e3 * ends[1]:.3f} ms "
        "at the ends.",
        bool(inside),
        "Within this range the release time has its smallest value at an end.",
    )
