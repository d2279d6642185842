"""Trends against tables made with known exponents, slopes and corners."""

import numpy as np
import pandas as pd
import pytest

from eaclutch.studies.trends import bandwidth, force_exponents, release_by_frequency, slope


def table(exponent: float) -> pd.DataFrame:
    rows = [
        {"width_mm": 2.0, "preload_n": 0.1, "frequency_hz": f, "voltage_v": v,
         "shear_capacity_n": 1e-5 * (1 + 1 / f) * v**exponent, "release_time_10_s": 3e-4,
         "release_time_90_s": 9e-4 + 1e-7 * v}
        for f in (1.0, 10.0)
        for v in (150.0, 200.0, 300.0)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def test_exponent_is_recovered_and_wide_strips_left_out():
    runs = table(1.7)
    wide = runs.assign(width_mm=5.0, shear_capacity_n=1.0)
    found = force_exponents(pd.concat([runs, wide]))
    np.testing.assert_allclose(found["exponent"], 1.7, rtol=1e-9)
    assert list(found["voltages"]) == [3, 3]


def test_slope_has_its_standard_error_and_needs_levels():
    runs = table(2.0)
    found, error = slope(runs, "voltage_v", "release_time_90_s", runs["frequency_hz"] > 0)
    assert found == pytest.approx(1e-7, rel=1e-6)
    assert error < 1e-12
    assert np.isnan(slope(runs, "width_mm", "release_time_90_s", runs["frequency_hz"] > 0)[0])


def test_bandwidth_of_a_first_order_fall():
    assert bandwidth(lambda f: 1 / (1 + f / 2000.0), low=1e-3) == pytest.approx(2000.0, rel=1e-4)
    assert np.isnan(bandwidth(lambda f: np.ones_like(f)))


def test_release_table_counts_runs():
    found = release_by_frequency(table(2.0))
    assert list(found["release_time_90_s_runs"]) == [3, 3]
