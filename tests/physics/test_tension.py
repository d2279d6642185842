"""The clamped film's spring: from where it is drawn, and what it keeps off the contact."""

from __future__ import annotations

import pytest

from eaclutch.physics.effects import BASE
from eaclutch.physics.kernels import forces
from eaclutch.physics.model import ClutchModel

SPRING = {"film_tension.stiffness": 1e6, "film_tension.hardening": 2e11}


@pytest.fixture(scope="module")
def tight(bench) -> ClutchModel:
    return ClutchModel(bench, (*BASE, "film_tension"))


def _row(tight: ClutchModel, runs, free_gap: float):
    return tight.rows(runs(), SPRING | {"film_tension.free_gap": free_gap})[0][0, 0]


@pytest.mark.parametrize("free_gap", [0.0, 5e-6, 9e-6])
def test_its_force_grows_from_the_gap_before(tight, runs, free_gap):
    """s (y + b y^3), y counted from the free gap where that is the wider one; the slope is its derivative."""
    row, before, h = _row(tight, runs, free_gap), 6e-6, 4e-6
    start = max(free_gap, before)
    spring = 1e6 * 55.5e-3
    expected = sum(
        sign * spring * (start - gap) * (1.0 + 2e11 * (start - gap) ** 2)
        for sign, gap in ((1, h), (-1, before))
    )
    force, slope = forces.tension(row, before, h)
    assert force == pytest.approx(expected, rel=1e-12)
    assert forces.tension(row, before, before)[0] == pytest.approx(0.0, abs=1e-12)
    higher, _ = forces.tension(row, before, h - 1e-10)
    assert slope == pytest.approx((higher - force) / 1e-10, rel=1e-3)


def test_a_film_that_the_preload_has_drawn_is_stiffer_and_holds_more(tight, runs):
    """The share of the capacity that a spring costs: with a wide free gap more at a large preload, else less."""
    light, heavy = (runs(voltage=300.0, friction_before=f) for f in (0.1, 0.6))

    def lost(conditions, free_gap: float) -> float:
        spring = SPRING | {"film_tension.free_gap": free_gap}
        with_it = tight.predict(conditions, spring).values["shear_capacity_n"][0, 0]
        return float(tight.predict(conditions).values["shear_capacity_n"][0, 0] - with_it)

    assert lost(light, 0.0) > 1.2 * lost(heavy, 0.0) > 0.0
    assert lost(heavy, 1.2e-5) > 1.2 * lost(light, 1.2e-5)
