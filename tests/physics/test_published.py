"""The preset of the published scripts: the paper's slopes, and what its choices do."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.physics.published import multiplier, published_release

PRELOAD = 0.125


def test_slope_over_voltage_is_the_papers():
    voltages = [100.0, 300.0]
    times = [published_release(v, 2e-3, 2e-3, PRELOAD, 0.85).release_time for v in voltages]
    assert 1e6 * (times[1] - times[0]) / 200 == pytest.approx(-0.25, abs=0.02)
    assert 0.85e-3 < times[1] < times[0] < 1e-3


def test_slope_over_width_is_the_papers():
    times = [published_release(300.0, w, 2e-3, PRELOAD, 0.75).release_time for w in (2e-3, 6e-3)]
    assert 1e6 * (times[1] - times[0]) / 4 == pytest.approx(142.3, rel=0.08)


def test_starting_at_the_ratio_instead_shortens_the_release():
    scripts = published_release(300.0, 2e-3, 2e-3, PRELOAD, 0.8)
    words = published_release(300.0, 2e-3, 2e-3, PRELOAD, 0.8, start_at_ratio=True)
    assert words.start_force > 2 * scripts.start_force
    assert words.release_time_10 < scripts.release_time_10 < scripts.release_time


def test_multiplier_nears_the_printed_line():
    voltages = np.array([150.0, 200.0, 250.0, 300.0])
    assert [multiplier(v) for v in voltages] == pytest.approx(list(2.40 - 0.0058 * voltages), abs=0.06)
