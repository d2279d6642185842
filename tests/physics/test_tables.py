"""The compiled look-ups against the definitions' quadratures, over the range and past its ends."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import gamma, ndtr

from eaclutch.physics import laws
from eaclutch.physics.kernels import lookup
from eaclutch.physics.tables import tables


def test_contact():
    rng = np.random.default_rng(1)
    for x in rng.uniform(-6, 12, 200):
        value, slope = lookup.log_contact(x, tables().contact)
        assert np.exp(value) == pytest.approx(float(laws.greenwood_williamson(x)), rel=1e-8)
        step = 1e-4
        either = [np.log(laws.greenwood_williamson(x + s)) for s in (-step, step)]
        assert slope == pytest.approx(float(either[1] - either[0]) / (2 * step), rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("rule", ["published", "clamped"])
def test_averaged_force(rule):
    rng = np.random.default_rng(2)
    for _ in range(60):
        sigma, film = rng.uniform(0.5e-6, 6e-6), np.exp(rng.uniform(np.log(5e-8), np.log(3e-5)))
        gap, cut = rng.uniform(0.0, 14e-6), rng.uniform(0.0, 0.98)
        cut = 0.0 if rule == "clamped" else cut
        a, u = (1 - cut) * film / sigma, (gap + cut * film) / sigma
        row, coordinate = lookup.rough_row(a)
        average = lookup.rough_value(a, row, coordinate, u, tables().roughness) / sigma**2
        if rule == "clamped":
            average += ndtr(-gap / sigma) / film**2
        assert average == pytest.approx(laws.roughness_average(gap, film, sigma, cut, rule), rel=2e-6)
        j, by_a, by_u = lookup.rough_slopes(a, row, coordinate, u, tables().roughness)
        for slope, da, du in ((by_a, 1e-4 * a, 0.0), (by_u, 0.0, 1e-4)):
            ends = [
                lookup.rough_value(a + s * da, *lookup.rough_row(a + s * da), u + s * du, tables().roughness)
                for s in (-1, 1)
            ]
            assert slope == pytest.approx((ends[1] - ends[0]) / (2 * (da + du)), rel=1e-3, abs=1e-6 * j)


def test_averaged_force_far_from_the_cut_joins_its_series():
    below, above = lookup.ROUGH_U_TOP * (1 - 1e-9), lookup.ROUGH_U_TOP * (1 + 1e-9)
    values = [lookup.rough_value(0.1, *lookup.rough_row(0.1), u, tables().roughness) for u in (below, above)]
    assert values[0] == pytest.approx(values[1], rel=2e-6)


def test_step_response():
    rng = np.random.default_rng(3)
    for _ in range(150):
        exponent, y = rng.uniform(0.2, 1.0), np.exp(rng.uniform(-12, 12))
        value, slope = lookup.relaxation(exponent, y, tables().relaxation)
        assert value == pytest.approx(laws.mittag_leffler(exponent, y), abs=1e-6)
        ends = [lookup.relaxation(exponent, y * np.exp(s), tables().relaxation)[0] for s in (-1e-3, 1e-3)]
        assert slope == pytest.approx((ends[1] - ends[0]) / 2e-3, abs=1e-5)


def test_step_response_beyond_the_table():
    for exponent in (0.3, 0.56, 0.95):
        early = lookup.relaxation(exponent, 1e-17, tables().relaxation)[0]
        assert 1 - early == pytest.approx(1e-17**exponent / gamma(1 + exponent), rel=1e-2, abs=1e-9)
        late = lookup.relaxation(exponent, 1e13, tables().relaxation)[0]
        assert late == pytest.approx(1e13**-exponent / gamma(1 - exponent), rel=2e-2, abs=1e-9)
