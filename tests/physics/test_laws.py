"""The definitions against numbers worked out apart from them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erfcx

from eaclutch.physics import laws
from eaclutch.records import Pad

PARALLEL = Pad(type="parallel_plate", film_thickness=24e-6, overlap_length=55.5e-3)


def test_averaged_force_reproduces_the_published_numbers():
    force = [
        laws.force_scale(Pad(), 2e-3) * 300**2 * laws.roughness_average(h * 1e-6, 24e-6 / 55.5656, 2.70572e-6)
        for h in (4, 5, 6, 8)
    ]
    assert force == pytest.approx([5.33565, 2.97823, 1.51116, 0.34937], rel=3e-5)


def test_cut_multiplies_the_force_as_stated():
    film, h = 24e-6 / 55.5656, 5.5e-6
    base = laws.roughness_average(h, film, 2.70572e-6)
    ratios = [laws.roughness_average(h, film, 2.70572e-6, cut) / base for cut in (0.9, 0.95, 0.99)]
    assert ratios == pytest.approx([1.5, 2.8, 12.6], rel=0.05)
    clamped = laws.roughness_average(h, film, 2.70572e-6, rule="clamped")
    assert clamped / base == pytest.approx(0.76, abs=0.02)


@pytest.mark.parametrize("x", [-3.0, 0.0, 1.0, 4.0])
def test_contact_integral_is_its_definition(x):
    direct = quad(
        lambda s: (s - x) ** 1.5 * np.exp(-s * s / 2) / np.sqrt(2 * np.pi), x, x + 14, epsabs=0, epsrel=1e-11
    )[0]
    assert laws.greenwood_williamson(x) == pytest.approx(direct, rel=1e-9)


def test_contact_law_bends_towards_exponential_heights():
    x = np.linspace(-6.0, 14.0, 401)
    log_load = np.log(laws.greenwood_williamson(x))
    assert np.array_equal(laws.bent(log_load, 0.0), log_load)
    # it still lifts less the wider the gap, however far the parameter's bounds let it bend
    assert all(np.all(np.diff(laws.bent(log_load, bend)) < 0) for bend in (-1.0, 1.5))
    # 0.80 is a straight line of G's slope at two roughnesses, as far as a clutch's gap goes
    near = np.linspace(1.5, 3.0, 31)
    straight = laws.BEND_LOG_LOAD + laws.BEND_SLOPE * (near - 2.0)
    bent = laws.bent(np.log(laws.greenwood_williamson(near)), 0.80)
    assert bent == pytest.approx(straight, abs=0.03)
    assert np.log(laws.greenwood_williamson(near)) != pytest.approx(straight, abs=0.2)


def test_step_response_has_its_closed_form_at_one_half():
    # E_1/2(-sqrt y) = exp(y) erfc(sqrt y)
    for y in (1e-4, 0.3, 5.0, 200.0):
        assert laws.mittag_leffler(0.5, y) == pytest.approx(erfcx(np.sqrt(y)), rel=1e-9)
    assert laws.mittag_leffler(1.0, 2.0) == pytest.approx(np.exp(-2.0))


def test_polarisation_is_93_percent_after_100_us():
    assert 1 - laws.mittag_leffler(0.562, 100 / 2.82) == pytest.approx(0.93, abs=0.005)


def test_gap_and_capacitance_invert_each_other():
    gap = np.array([1e-6, 5e-6, 2e-5])
    for pad in (Pad(), PARALLEL):
        c = laws.capacitance(pad, 2e-3, gap, 50.0, 24e-6)
        assert laws.gap_from_capacitance(pad, 2e-3, c, 50.0, 24e-6) == pytest.approx(gap, rel=1e-10)
    # four times the area, and no halving of the voltage, for a plate of the comb's active area
    plate = Pad(type="parallel_plate", overlap_length=28 * 1.5e-3)
    assert laws.capacitance(plate, 2e-3, 5e-6, 50.0, 24e-6) == pytest.approx(
        4 * laws.capacitance(Pad(), 2e-3, 5e-6, 50.0, 24e-6)
    )
    assert laws.force_scale(plate, 2e-3) == pytest.approx(4 * laws.force_scale(Pad(), 2e-3))


def test_squeeze_film_coefficient_by_hand():
    # 96 x 1.85e-5 x (2e-3)^3 x 55.5e-3 / pi^4
    assert laws.squeeze_film_coefficient(55.5e-3, 2e-3) == pytest.approx(8.0952e-15, rel=1e-4)
