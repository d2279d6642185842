"""Film and substrate that are not parallel: the forces' mean over the gaps, and where they balance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ndtr

from eaclutch.physics import laws
from eaclutch.physics.effects import BASE
from eaclutch.physics.kernels import contact as faces
from eaclutch.physics.kernels import forces
from eaclutch.physics.kernels.statics import gap_at_load
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.tables import tables

SIGMA, LENGTH, WIDTH = 2.8e-6, 55.5e-3, 2e-3  # m: the defaults
HALF = 1.5 * SIGMA
TILT = {"gap_tilt.angle": 2.0 * HALF / WIDTH, "gap_tilt.levelling": 0.0}


@pytest.fixture(scope="module")
def tilted(bench) -> ClutchModel:
    return ClutchModel(bench, (*BASE, "gap_tilt", "surface_adhesion"))


def _mean(law, h: float, half: float = HALF) -> float:
    """Of ``law`` over gaps spread evenly by ``half`` about ``h``."""
    total = quad(lambda t: float(law(t)), h - half, h + half, epsabs=0, epsrel=1e-10)[0]
    return total / (2.0 * half)


def _contact(h: float) -> float:
    return float(laws.contact_force(h, 5.4e14, SIGMA, LENGTH, WIDTH))


@pytest.mark.parametrize("h", [1.6 * SIGMA, 3.0 * SIGMA, 5.0 * SIGMA])
def test_each_force_is_its_mean_over_the_gaps(tilted, runs, h):
    attraction = {"surface_adhesion.pressure": 1e4, "surface_adhesion.range_ratio": 2.0}
    row = tilted.rows(runs(), {**TILT, **attraction})[0][0, 0]
    assert row["gap_half_spread"] == pytest.approx(HALF)
    contact, slope = faces.contact(row, h, tables())
    assert abs((contact - _mean(_contact, h)) / slope) < 1e-3 * h  # the gap that it puts off
    adhesion, _ = faces.adhesion(row, h, tables())
    wells = _mean(lambda t: row["adhesion_force"] * ndtr(-t / (2.0 * SIGMA)), h)
    assert adhesion == pytest.approx(wells, rel=1e-4)
    amount, kappa = 1e-12, 10.0
    field = forces.make_field(row, amount, kappa, 1.0)
    level = tilted.rows(runs(), attraction)[0][0, 0]
    expected = _mean(lambda t: forces.field_force(level, field, t, tables()), h)
    assert forces.field_force(row, field, h, tables()) == pytest.approx(expected, rel=3e-4)


@pytest.mark.parametrize("levelling", [0.0, 2.0])
@pytest.mark.parametrize("h", [1.2 * SIGMA, 2.0 * SIGMA, 4.0 * SIGMA])
def test_slopes_are_those_of_the_means(tilted, runs, h, levelling):
    attraction = {"surface_adhesion.pressure": 1e4, "surface_adhesion.range_ratio": 2.0}
    tilt = TILT | {"gap_tilt.levelling": levelling, "gap_tilt.air_share": 0.6}
    row, step = tilted.rows(runs(), {**tilt, **attraction})[0][0, 0], 1e-10
    field = forces.make_field(row, 1e-12, 10.0, 1.0)
    for law in (
        lambda t: faces.contact(row, t, tables()),
        lambda t: faces.adhesion(row, t, tables()),
        lambda t: forces.field_slopes(row, field, t, tables())[:2],
        lambda t: forces.squeeze(row, t, tables()),
        lambda t: faces.half_spread(row, t, tables()),
    ):
        difference = (law(h + step)[0] - law(h - step)[0]) / (2.0 * step)
        assert law(h)[1] == pytest.approx(difference, rel=1e-4, abs=1e-12)
    force, _, by_film, value = forces.field_slopes(row, field, h, tables())
    other = [forces.make_field(row, 1e-12, 10.0 * (1.0 + s), 1.0) for s in (-1e-6, 1e-6)]
    ends = [forces.field_force(row, f, h, tables()) for f in other]
    assert by_film == pytest.approx((ends[1] - ends[0]) / (other[1][3] - other[0][3]), rel=1e-4)
    assert force == pytest.approx(forces.field_force(row, field, h, tables()), rel=1e-9)
    assert value * 1e-12 == pytest.approx(force, rel=1e-12)


@pytest.mark.parametrize("spread", [0.5, 1.5, 2.2])
def test_the_film_rests_where_the_mean_contact_bears_its_load(tilted, runs, spread):
    half = spread * SIGMA
    p = tilted.predict(runs(), TILT | {"gap_tilt.angle": 2.0 * half / WIDTH})
    load = p.state["preload"][0, 0] + 9.81 * 1780.0 * 24e-6 * LENGTH * WIDTH
    rest = brentq(lambda h: _mean(_contact, h, half) - load, SIGMA, 10.0 * SIGMA, xtol=1e-16)
    assert p.state["gap_before"][0, 0] == pytest.approx(rest, rel=1e-3)
    level = tilted.predict(runs())
    assert level.state["gap_before"][0, 0] < rest


def test_a_slight_tilt_is_a_slightly_rougher_film(tilted, bench, runs):
    """For a spread far below the roughness the mean over it is a Gaussian's, whose variances add."""
    spread = 0.1 * SIGMA
    slight = tilted.predict(runs(), TILT | {"gap_tilt.angle": spread * np.sqrt(12.0) / WIDTH})
    rougher = ClutchModel(bench, BASE).predict(runs(), {"roughness_sd": float(np.hypot(SIGMA, spread))})
    for name in ("gap_before", "gap_driven"):
        found, expected = slight.state[name][0, 0], rougher.state[name][0, 0]
        assert found == pytest.approx(expected, rel=1e-4)


def test_the_closer_it_is_the_more_level_it_turns(tilted, runs):
    """Half as tilted where parallel faces would carry 1 / l; free to turn, it acts as a parallel one."""
    row = tilted.rows(runs(), TILT | {"gap_tilt.levelling": 1.0})[0][0, 0]
    there = brentq(lambda h: _contact(h) - 1.0, 0.1 * SIGMA, 9.0 * SIGMA, xtol=1e-16)
    assert faces.half_spread(row, there, tables())[0] == pytest.approx(0.5 * HALF, rel=1e-4)
    gaps = [
        tilted.predict(runs(), TILT | {"gap_tilt.levelling": levelling}).state["gap_driven"][0, 0]
        for levelling in (0.0, 0.3, 20.0)
    ]
    level = tilted.predict(runs()).state["gap_driven"][0, 0]
    assert gaps[0] > gaps[1] > gaps[2] and gaps[2] == pytest.approx(level, rel=0.02)


def test_squeezed_air_feels_the_mean_of_the_inverse_cubes(tilted, runs):
    """To the second order in spread over gap; none of it without a share, and no more than the share of it."""
    level = tilted.rows(runs(), {})[0][0, 0]
    h = 6.0 * HALF
    plain = forces.squeeze(level, h, tables())[0]
    found = [
        forces.squeeze(tilted.rows(runs(), TILT | {"gap_tilt.air_share": share})[0][0, 0], h, tables())[0]
        for share in (0.0, 0.3, 1.0)
    ]
    assert found[0] == pytest.approx(plain, rel=1e-12)
    assert found[2] == pytest.approx(_mean(lambda t: plain * (h / t) ** 3, h), rel=3e-3)
    # Reynolds' equation across a wedge with both sides open, y in half widths: d/dy(gap^3 dp/dy) = 12 mu dh/dt
    cubed = [quad(lambda y, n=n: y**n / (1.0 + y * HALF / h) ** 3, -1.0, 1.0)[0] for n in range(3)]
    across = (cubed[2] - cubed[1] ** 2 / cubed[0]) / (2.0 / 3.0)
    assert found[1] == pytest.approx(plain * across, rel=1e-3)


def test_a_tilted_fixture_has_the_mean_of_the_capacitances(tilted, runs):
    tilt = TILT | {"gap_tilt.fixture_share": 1.0}
    force = np.array([0.1, 4.0])
    found = tilted.capacitance(force, WIDTH, tilt)[0]
    row = tilted.rows(runs(), tilt)[0][0, 0]
    film = 24e-6 / 54.2
    for value, load in zip(found, force, strict=True):
        rest = gap_at_load(row, load * 55.5 / 60.0, tables())  # the fixture's overlap is longer
        level = float(laws.capacitance_scale(tilted.bench.pad, WIDTH))
        mean = _mean(lambda t, level=level: level / (film + max(t, 0.0)), rest)
        assert value == pytest.approx(mean, rel=5e-3) and value > 1.01 * level / (film + rest)


@pytest.mark.parametrize("load", [0.01, 0.5, 1.0, 2.0, 8.0])
def test_a_wide_wedge_that_snaps_shut_still_bears_its_load(tilted, runs, load):
    wide = {"gap_tilt.angle": 2.0 * 2.2 * SIGMA / WIDTH, "gap_tilt.levelling": 1.0}
    row = tilted.rows(runs(), wide)[0][0, 0]
    gaps = np.linspace(0.2, 9.0, 200) * SIGMA
    assert any(np.diff([faces.contact(row, h, tables())[0] for h in gaps]) > 0.0), "it does not snap"
    assert faces.contact(row, gap_at_load(row, load, tables()), tables())[0] == pytest.approx(load, rel=1e-9)
