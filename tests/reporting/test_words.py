"""Numbers and units as people read them."""

from __future__ import annotations

import math

import pytest

from eaclutch.reporting.glance import set_words
from eaclutch.reporting.words import (
    measured,
    number,
    observable_words,
    percent,
    plain,
    scale_for,
    unit_words,
    with_error,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (1.2345, "1.23"),
        (-0.01234, "−0.0123"),
        (123456.0, "1.23·10⁵"),
        (2.7e-6, "2.7·10⁻⁶"),
        (None, "–"),
        (math.nan, "–"),
    ],
)
def test_number(value: float | None, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.0, "0 %"), (0.004, "< 1 %"), (0.996, "> 99 %"), (1.0, "100 %"), (0.885, "88 %"), (None, "–")],
)
def test_percent_is_never_certain_of_what_is_not(share: float | None, text: str) -> None:
    assert percent(share).replace("\u00a0", " ") == text


def test_units_take_a_prefix_that_suits_the_values() -> None:
    scale = scale_for([1.1e-3, 0.9e-3, 1.3e-3], "s")
    assert scale.unit == "ms" and float(scale(1e-3)) == pytest.approx(1)
    assert scale_for([0.3], "1").unit == "" and scale_for([18018.0], "N/m").unit == "kN/m"


def test_names() -> None:
    assert observable_words("release_time_90_s") == "90\u00a0% release time"
    assert observable_words("ramp_rate_early_n_s") == "early ramp rate"
    assert measured(1.0, 0.9, 1.1, "N") == "1.00 (0.900 to 1.10) N"


def test_units_and_settings_as_one_writes_them() -> None:
    assert unit_words("N m^-3.5") == "N m⁻³·⁵" and unit_words("m2/V2") == "m²/V²" and unit_words("1") == ""
    assert (plain(10000.0), plain(0.1), plain(6.0)) == ("10000", "0.1", "6")


@pytest.mark.parametrize(
    ("mean", "sd", "unit", "text"),
    [
        (1.2e-4, 1.5e-5, "m/N", "120 ± 15 µm/N"),
        (1.2e-4, 0.0, "m/N", "120 µm/N (no uncertainty found)"),
        (3.97e-14, 9.8e-15, "m2/V2", "(3.97 ± 0.98)·10⁻¹⁴ m²/V²"),
        (1.1e-3, 5e-5, "kg", "1.100 ± 0.050 g"),
        (-0.4, 0.051, "1", "−0.400 ± 0.051"),
        (6.1e-13, 7.3e-13, "F", "610 ± 730 fF"),
    ],
)
def test_a_value_is_written_to_its_error(mean: float, sd: float, unit: str, text: str) -> None:
    assert with_error(mean, sd, unit) == text


@pytest.mark.parametrize(
    ("joined", "text"),
    [
        ("gas_slip+trapped_charge", "gas slip with trapped charge"),
        ("trapped_charge", "trapped charge"),
        ("unknown", "an effect outside the library"),
        ("none", "no gap"),
    ],
)
def test_a_pair_that_runs_would_separate_reads_as_one(joined, text):
    assert set_words(joined) == text
