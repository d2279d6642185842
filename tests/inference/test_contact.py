"""The contact stage: its likelihood against the dense normal, recovery, and what little data does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from eaclutch.inference import gaussian_levels
from eaclutch.inference.gaussian_levels import LevelDesign, Levels
from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.laplace import fit
from eaclutch.inference.stages.contact import ContactSettings, FilmOffset, InverseContact, contact_problem
from eaclutch.inference.start import starting_walkers
from eaclutch.physics.laws import capacitance_scale, contact_force, greenwood_williamson
from eaclutch.physics.parameters import base_parameters
from eaclutch.records import Bench, CapacitanceFixture, CapacitanceReadings, InputError, Substrate

BENCH = Bench("x", substrates={"brass": Substrate(thickness={2e-3: 2e-3, 2.5e-3: 2.5e-3, 3e-3: 3e-3})})
FILM = FilmOffset(24e-6 / 52, 2.5e-8, 24e-6, 28.0, 6e-7)
TRUE = {"contact_stiffness": 5e14, "roughness_sd": 2.8e-6}


def readings(rng, *, trials=3, widths=(2e-3, 2.5e-3, 3e-3), points=12, noise=0.004, spread=1e-7, stray=0.0):
    """Capacitance by the definitions in `laws`, solved for the gap by bisection (not by the stage's own table)."""
    rows = []
    for width in widths:
        shift = spread * rng.standard_normal()
        for trial in range(trials):
            own = shift + spread * rng.standard_normal()
            for force in np.exp(rng.uniform(np.log(0.1), np.log(8.0), points)):
                low, high = -2e-5, 2e-5
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    load = contact_force(
                        middle,
                        TRUE["contact_stiffness"],
                        TRUE["roughness_sd"],
                        BENCH.fixture.overlap_length,
                        width,
                    )
                    low, high = (middle, high) if load > force else (low, middle)
                gap = 24e-6 / 52 + 0.5 * (low + high) + own
                value = capacitance_scale(BENCH.pad, width, BENCH.fixture.overlap_length) / gap + stray
                rows.append(
                    (force, value * (1 + noise * rng.standard_normal()), width, f"w{width:g}-{trial}")
                )
    force, value, width, trial = zip(*rows, strict=True)
    return CapacitanceReadings(
        np.array(force), np.array(value), np.array(width), trial, ("made",) * len(force)
    )


def parameters():
    return dict(HYPERPARAMETERS) | base_parameters(BENCH, "linear")


def around_mode(problem, rng, draws=4000):
    """Mean and sd of the Gaussian around the posterior's mode, in ln of the parameters."""
    start = starting_walkers(problem.log_density, len(problem.priors), 40, rng)
    u = start.mode + rng.standard_normal((draws, len(problem.priors))) @ start.root.T
    values = np.log(problem.priors.from_normal(u))
    return values.mean(axis=0), values.std(axis=0)


def test_levels_are_the_dense_normal():
    rng = np.random.default_rng(0)
    width = np.repeat([3.0, 1.0, 2.0], [5, 7, 4])
    trial = np.array([f"{w}-{i % 2}" for i, w in enumerate(width)])
    design = LevelDesign.of(2 * rng.standard_normal(16), width, trial, 0.5, 1.0)
    residual, noise = rng.standard_normal((3, 16)), rng.uniform(0.1, 0.3, (3, 16))
    wide, own = np.array([0.2, 0.5, 1.0]), np.array([0.3, 0.1, 0.6])
    levels = Levels(rng.uniform(-2, -1, (3, 16)), noise, wide, own, 0.7)
    value, offset, variance = gaussian_levels.marginal(residual, levels, design)
    points = gaussian_levels.pointwise(residual, levels, design)
    order = design.order
    for i in range(3):
        dense = gaussian_levels.covariance(levels, i, design)
        normal = multivariate_normal(np.zeros(16), dense)
        assert value[i] == pytest.approx(normal.logpdf(residual[i, order]))
        gain = 0.7**2 * levels.sensitivity[i, order] @ np.linalg.inv(dense)
        assert offset[i] == pytest.approx(gain @ residual[i, order])
        assert variance[i] == pytest.approx(0.7**2 - gain @ levels.sensitivity[i, order] * 0.7**2)
        for first in (0, 9):
            rest = np.delete(np.arange(16), first)
            solved = np.linalg.solve(dense[np.ix_(rest, rest)], dense[rest, first])
            left = dense[first, first] - dense[first, rest] @ solved
            conditional = multivariate_normal(solved @ residual[i, order][rest], left)
            assert points[i, order[first]] == pytest.approx(conditional.logpdf(residual[i, order[first]]))


def test_level_kernel_and_replicates():
    rng = np.random.default_rng(1)
    position = np.linspace(-4, 2, 30)
    trial = np.array(["a"] * 15 + ["b"] * 15)
    design = LevelDesign.of(position, np.ones(30), trial, 0.5, 1.0)
    distance = position[design.order][:, None] - position[design.order][None, :]
    expected = 0.5 + 0.5 * np.exp(-0.5 * distance**2)
    np.testing.assert_allclose(design.basis @ design.basis.T, expected, atol=1e-4)
    draws = 20000
    levels = Levels(
        np.full((draws, 30), -1.5), np.full((draws, 30), 0.04), np.full(draws, 0.3), np.full(draws, 0.2), 0.1
    )
    made = gaussian_levels.replicate(levels, design, rng)[:, design.order]
    np.testing.assert_allclose(np.cov(made.T), gaussian_levels.covariance(levels, 0, design), atol=0.02)


def test_inverse_contact_law():
    x = np.array([-3.0, -0.5, 0.0, 1.0, 3.0, 8.0])
    back = InverseContact()(np.log(greenwood_williamson(x)))
    np.testing.assert_allclose(back, x, atol=1e-5)


def test_recovers_the_truth_and_learns_from_data():
    rng = np.random.default_rng(3)
    problem = contact_problem(readings(rng), BENCH, parameters(), FILM)
    assert len(problem.priors) <= 6
    mean, sd = around_mode(problem, rng)
    truth = np.log(list(TRUE.values()))
    assert np.all(np.abs(mean[:2] - truth) < 3 * sd[:2])
    assert sd[0] < 0.6 and sd[1] < 0.1  # priors: 1.5 and 0.4


@pytest.mark.parametrize("stated", [0.002, 0.01, 0.03])
def test_a_force_error_that_is_stated_too_large_draws_nothing_away(stated):
    """The readings' forces are exact: what is said of their error changes how much is known, not what."""
    rng = np.random.default_rng(8)
    made = readings(rng, trials=2, points=60, noise=0.002, spread=3e-8)
    problem = contact_problem(made, BENCH, parameters(), FILM, ContactSettings(force_sd=stated))
    mean, sd = around_mode(problem, rng)
    assert np.all(np.abs(mean[:2] - np.log(list(TRUE.values()))) < 3 * sd[:2])
    assert sd[0] < 0.4 and sd[1] < 0.1


def test_the_force_error_counts_where_a_single_reading_shows_no_slope():
    made = readings(np.random.default_rng(6), trials=1, widths=(2e-3,), points=1)
    spreads = []
    for share in (0.01, 0.4):
        settings = ContactSettings(force_sd=share * float(made.force[0]))
        problem = contact_problem(made, BENCH, parameters(), FILM, settings)
        spreads.append(around_mode(problem, np.random.default_rng(1))[1][1])
    assert spreads[1] > 1.5 * spreads[0]


def test_calibrated_over_campaigns():
    """k and sigma within their posterior over 30 campaigns: neither over- nor underconfident."""
    rng = np.random.default_rng(11)
    scores = []
    for _ in range(30):
        made = readings(rng, trials=2, points=8, spread=1.5e-7)
        mean, sd = around_mode(contact_problem(made, BENCH, parameters(), FILM), rng, 500)
        scores.append((mean[:2] - np.log(list(TRUE.values()))) / sd[:2])
    assert 0.5 < np.sqrt(np.mean(np.square(scores))) < 1.5


def test_fitted_stray_capacitance_shows_and_widens():
    rng = np.random.default_rng(5)
    made = readings(rng, stray=2e-12, spread=1e-9)
    named = parameters()
    problem = contact_problem(made, BENCH, named, FILM, ContactSettings(stray_sd=5e-12))
    assert problem.priors.names[2] == "stray_capacitance" and len(problem.priors) <= 6
    start = starting_walkers(problem.log_density, len(problem.priors), 40, rng)
    stray = problem.priors.from_normal(start.mode)[2]
    sd = problem.priors.slope(start.mode)[2] * np.sqrt((start.root @ start.root.T)[2, 2])
    assert abs(stray - 2e-12) < 3 * sd < 1.2e-11


def test_without_readings_the_prior_is_the_answer():
    problem = contact_problem(None, BENCH, parameters(), FILM)
    assert not problem.has_data and "no usable capacitance readings" in problem.notes
    drawn = problem.derived(problem.priors.sample(np.random.default_rng(0), 2000), np.random.default_rng(0))
    assert drawn["film_thickness"].std() == pytest.approx(np.hypot(28 * 2.5e-8, 6e-7), rel=0.1)


def test_little_data_widens_to_the_prior_and_is_said():
    rng = np.random.default_rng(7)
    one = readings(rng, widths=(2e-3,), trials=1, points=1)
    problem = contact_problem(one, BENCH, parameters(), FILM)
    assert any("one width only" in note for note in problem.notes)
    assert any("only 1 readings" in note for note in problem.notes)
    _, sd = around_mode(problem, rng)
    assert sd[0] > 1.1  # of a prior sd of 1.5


def test_what_is_left_out_is_said():
    rng = np.random.default_rng(8)
    made = readings(rng)
    strange = replace(made, width=np.where(made.width == 3e-3, 6.35e-3, made.width), force=made.force.copy())
    strange.force[0] = 0.001
    problem = contact_problem(strange, BENCH, parameters(), FILM, ContactSettings(force_max=6.0))
    text = "; ".join(problem.notes)
    assert "6.35 mm left out: no substrate" in text and "above 6 N" in text and "below 0.02 N" in text
    assert not np.any(np.isclose(problem.coords["width"], 6.35e-3))


def test_impossible_stray_capacitance_names_the_key():
    made = readings(np.random.default_rng(9))
    bench = replace(BENCH, fixture=CapacitanceFixture(stray_capacitance=1e-9))
    with pytest.raises(InputError, match="stray_capacitance_pf"):
        contact_problem(made, bench, parameters(), FILM)


def test_laplace_fit_of_the_same_data_agrees():
    """Without levels the stage is a plain least-squares problem: the general Laplace fit finds the same mode."""
    rng = np.random.default_rng(12)
    made = readings(rng, spread=0.0)
    scale = capacitance_scale(BENCH.pad, made.width, BENCH.fixture.overlap_length)
    inverse = InverseContact()

    def residual(theta):
        k, sigma = theta[:, :1], theta[:, 1:]
        x = inverse(np.log(made.force / (k * BENCH.fixture.overlap_length * made.width * sigma**1.5)))
        return (np.log(made.capacitance) - np.log(scale / (24e-6 / 52 + sigma * x))) / 0.004

    found = fit(residual, [parameters()["contact_stiffness"], parameters()["roughness_sd"]])
    assert found.converged
    assert np.all(np.abs(np.log(found.mode / list(TRUE.values()))) < 4 * found.sd / found.mode)
