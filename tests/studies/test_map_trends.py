"""The paper's statements on design maps, on maps made to follow them and to break them."""

from __future__ import annotations

import numpy as np

from eaclutch.studies.map_trends import map_trends
from eaclutch.studies.sweep import DesignMap

DEFAULTS = {"voltage_v": 300.0, "width_mm": 2.0, "film_thickness_um": 24.0, "drive_time_us": 8.3}
VOLTAGES, WIDTHS = np.linspace(100, 300, 5), np.linspace(2, 6, 5)
THICKNESSES, TIMES = np.linspace(8, 40, 9), np.geomspace(1, 100, 5)


def drawn(name: str, levels: np.ndarray, release: np.ndarray, engagement: np.ndarray) -> DesignMap:
    """One draw of a map whose times are the outer product of a voltage's and the axis' own effect."""
    values = {
        "release_time_90_s": (release[:, None] / VOLTAGES)[None],
        "engagement_time_s": (engagement[:, None] * np.ones(5))[None],
    }
    return DesignMap("voltage_v", name, VOLTAGES, levels, values)


def maps() -> list[DesignMap]:
    return [
        drawn("width_mm", WIDTHS, WIDTHS**2, WIDTHS),
        drawn("film_thickness_um", THICKNESSES, 5 + (THICKNESSES - 20) ** 2 / 100, np.ones(9)),
        drawn("drive_time_us", TIMES, np.ones(5), TIMES),
    ]


def test_each_statement_is_judged_by_the_maps() -> None:
    width, voltage, engagement, thickness = map_trends(maps(), DEFAULTS)
    assert width.holds and "substrate width by a factor of 9.00" in width.ours
    assert voltage.holds and thickness.holds and "at 20 µm" in thickness.ours
    # a voltage that does nothing for engagement is not the paper's statement
    assert not engagement.holds and "voltage by a factor of 1.00" in engagement.ours


def test_a_minimum_at_the_edge_is_none() -> None:
    rising = drawn("film_thickness_um", THICKNESSES, THICKNESSES, np.ones(9))
    thickness = map_trends([rising], DEFAULTS)[-1]
    assert not thickness.holds and "at an end" in thickness.why


def test_maps_without_the_axes_say_nothing_of_them() -> None:
    assert [trend.printed for trend in map_trends(maps()[:1], DEFAULTS)][
        -1
    ] == "A higher voltage releases faster."
