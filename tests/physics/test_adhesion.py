"""Attraction without voltage: its law over the gap, its ends, and the gaps at which it balances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ndtr

from eaclutch.physics import laws
from eaclutch.physics.effects import BASE
from eaclutch.physics.kernels.batch import RESULTS, STATUSES, simulate_batch
from eaclutch.physics.kernels.contact import adhesion, contact
from eaclutch.physics.kernels.drive import RELEASING
from eaclutch.physics.kernels.film import equilibrium
from eaclutch.physics.kernels.release import END
from eaclutch.physics.kernels.statics import gap_at_load
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.tables import tables

SIGMA, AREA = 2.8e-6, 55.5e-3 * 2e-3  # m, m2: the defaults
PRESSURE = 8e4  # Pa


@pytest.fixture(scope="module")
def sticky(bench) -> ClutchModel:
    return ClutchModel(bench, (*BASE, "surface_adhesion"))


def _given(pressure: float, ratio: float) -> dict[str, float]:
    """Of an attraction whose full contact would be pulled by ``pressure``."""
    stated = pressure * ndtr(-2.0 / ratio) / ndtr(-2.0)
    return {"surface_adhesion.pressure": stated, "surface_adhesion.range_ratio": ratio}


@pytest.fixture
def pull(sticky, runs):
    """``pull(ratio, h)``: (attraction [N], its derivative [N/m]) at a gap h [m]."""
    return lambda ratio, h: adhesion(sticky.rows(runs(), _given(PRESSURE, ratio))[0][0, 0], h, tables())


@pytest.mark.parametrize("h", [1e-7, 3e-6, 8e-6])
def test_without_a_range_it_is_the_share_that_touches(pull, h):
    x = h / SIGMA
    force, slope = pull(1.0, h)
    assert force == pytest.approx(PRESSURE * AREA * ndtr(-x), rel=1e-12)
    assert slope == pytest.approx(
        -PRESSURE * AREA / SIGMA * math.exp(-x * x / 2) / math.sqrt(2 * math.pi), rel=1e-12
    )


@pytest.mark.parametrize("ratio", [1.5, 10.0])
def test_a_stated_pressure_pulls_a_lightly_pressed_film_as_hard_at_any_range(sticky, runs, ratio):
    found = [
        adhesion(
            sticky.rows(runs(), {"surface_adhesion.pressure": 1e4, "surface_adhesion.range_ratio": r})[0][
                0, 0
            ],
            2 * SIGMA,
            tables(),
        )
        for r in (1.0, ratio)
    ]
    assert found[1][0] == pytest.approx(found[0][0], rel=1e-9)


def test_far_beyond_the_gap_it_is_half_the_pressure(pull):
    """At ten sigma: 8 um away the attraction has lost a quarter of what it is at contact, the share all but 0.4 %."""
    at_contact, away = pull(10.0, 0.0)[0], pull(10.0, 8e-6)[0]
    assert at_contact == pytest.approx(0.5 * PRESSURE * AREA)
    assert away / at_contact == pytest.approx(2.0 * ndtr(-8.0 / 28.0), rel=1e-9)
    assert away / at_contact > 0.77 and pull(1.0, 8e-6)[0] / at_contact < 5e-3


@pytest.mark.parametrize("ratio", [1.0, 1.5, 4.0, 10.0])
def test_its_slope_is_that_of_the_force(pull, ratio):
    for h in (5e-7, 4e-6, 1e-5):
        step = 1e-10
        difference = (pull(ratio, h + step)[0] - pull(ratio, h - step)[0]) / (2 * step)
        assert pull(ratio, h)[1] == pytest.approx(difference, rel=1e-5)


def test_the_farther_it_reaches_the_closer_the_film_lies(sticky, runs):
    """Both gaps fall with the range; the one without voltage balances by the definitions."""
    ratios = (1.0, 1.5, 3.0, 10.0)
    found = [sticky.predict(runs(), _given(2e4, ratio)) for ratio in ratios]
    for name in ("gap_before", "gap_driven"):
        gaps = [p.state[name][0, 0] for p in found]
        assert (np.diff(gaps) < 0).all(), (name, gaps)
    weight = 9.81 * 1780.0 * 24e-6 * AREA
    for ratio, p in zip(ratios, found, strict=True):

        def balance(h, ratio=ratio, p=p):
            lift = float(laws.contact_force(h, 5.4e14, SIGMA, 55.5e-3, 2e-3))
            return lift - p.state["preload"][0, 0] - weight - 2e4 * AREA * ndtr(-h / (ratio * SIGMA))

        before = brentq(balance, 1e-6, 2e-5, xtol=1e-16)
        assert p.state["gap_before"][0, 0] == pytest.approx(before, rel=1e-7)


@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_the_fixture_is_pulled_as_hard_per_area(sticky, ratio):
    """Its overlap is 60 mm, the pad's 55.5 mm: contact and attraction grow alike, at the gap that the reading says."""
    force, pad = np.array([0.2, 1.0, 4.0]), sticky.bench.pad
    area = 60e-3 * 2e-3
    gaps = [
        brentq(
            lambda h, f=f: (
                float(laws.contact_force(h, 5.4e14, SIGMA, 60e-3, 2e-3))
                - PRESSURE * area * ndtr(-h / (ratio * SIGMA))
                - f
            ),
            1e-6,
            2e-5,
            xtol=1e-16,
        )
        for f in force
    ]
    kappa = laws.permittivity(1e3, 54.2, 4.0, 2.82e-6, 0.562)
    expected = laws.capacitance(pad, 2e-3, np.array(gaps), kappa, 24e-6)
    found = sticky.capacitance(force, 2e-3, {**_given(PRESSURE, ratio), "stray_capacitance": 0.0})
    assert found[0] == pytest.approx(expected, rel=1e-7)


def test_faces_part_with_more_pull_than_they_met_with(sticky, runs):
    """What comes before switch-off stays as it is, the release takes longer, and the rest that a fall heads for
    balances that pull."""
    ratio, given = 3.0, _given(4e4, 1.5)
    apart = given | {"surface_adhesion.separation_ratio": ratio}
    (met,), (parted,) = (
        sticky.predict(runs(), values).values["release_time_90_s"] for values in (given, apart)
    )
    assert (parted > 1.05 * met).all()
    for name in ("shear_capacity_n", "engagement_time_s"):
        np.testing.assert_array_equal(
            sticky.predict(runs(), apart).values[name], sticky.predict(runs(), given).values[name]
        )
    row, plain = (sticky.rows(runs(), values)[0][0, 0] for values in (apart, given))
    load = 0.3 + row["film_weight"]
    before = gap_at_load(plain, load, tables())
    pull_of = row["adhesion_force"]
    row["adhesion_force"] = ratio * pull_of
    gap, _ = equilibrium(row, END, before, load, before, RELEASING, tables())
    attraction, _ = adhesion(row, gap, tables())
    assert gap < before
    assert contact(row, gap, tables())[0] == pytest.approx(load + attraction, rel=1e-6)


def test_a_simulation_leaves_its_row_as_it_was(sticky, runs):
    rows = sticky.rows(runs(), _given(4e4, 1.5) | {"surface_adhesion.separation_ratio": 3.0})[0].reshape(-1)
    kept, tall = rows.copy(), (len(rows), len(RESULTS))
    status = np.empty((len(rows), len(STATUSES)), dtype=np.int8)
    simulate_batch(rows, tables(), True, True, 0.99, 1e-3, np.empty(tall), status)
    assert rows.tobytes() == kept.tobytes()
