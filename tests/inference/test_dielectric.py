"""The dielectric stage: its curve, its levels integrated out, recovery, single sources, weights."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.importance import width_check
from eaclutch.inference.source_levels import LEVEL_SCALE, curve, marginal
from eaclutch.inference.stages.dielectric import dielectric_problem
from eaclutch.inference.start import starting_walkers
from eaclutch.physics.laws import permittivity
from eaclutch.physics.parameters import base_parameters
from eaclutch.records import Bench, Spectrum

TRUE = (52.0, 4.0, 2.5e-6, 0.58)  # kappa_s, kappa_inf, tau, alpha
NAMES = ("kappa_static", "kappa_infinity", "relaxation_time", "cole_cole_exponent")


def parameters():
    return dict(HYPERPARAMETERS) | base_parameters(Bench("x"), "linear")


def spectra(rng, sources=3, points=25, noise=0.3, spread=0.06):
    made = []
    for source in range(sources):
        z = rng.standard_normal(4) * spread * LEVEL_SCALE
        values = (TRUE[0] * np.exp(z[0]), TRUE[1] * np.exp(z[3]), TRUE[2] * np.exp(z[1]), TRUE[3] + z[2])
        frequency = np.geomspace(1e2, 1e7, points)
        clean = permittivity(frequency, *values)
        made.append(Spectrum(f"s{source}", frequency, clean + noise * rng.standard_normal(points)))
    return made


def mode(problem, rng):
    start = starting_walkers(problem.log_density, len(problem.priors), 40, rng)
    u = start.mode + rng.standard_normal((3000, len(problem.priors))) @ start.root.T
    theta = problem.priors.from_normal(u)
    return dict(
        zip(problem.priors.names, zip(theta.mean(axis=0), theta.std(axis=0), strict=True), strict=True)
    )


def test_curve_is_cole_cole_and_its_slopes_are_right():
    log_omega = np.log(2 * np.pi * np.geomspace(10, 1e9, 30))
    shape, spread, level = np.array([*TRUE, 1.0]), 0.1, np.array([0.3, -0.5, 0.2, 0.4])
    plain, _ = curve(log_omega, shape, spread, np.zeros(4))
    np.testing.assert_allclose(plain, permittivity(np.exp(log_omega) / (2 * np.pi), *TRUE), rtol=1e-12)
    for beta in (1.0, 0.8):
        shape[4] = beta
        _, slope = curve(log_omega, shape, spread, level)
        for i in range(4):
            step = 1e-5 * np.eye(4)[i]
            above, below = (
                curve(log_omega, shape, spread, level + step)[0],
                curve(log_omega, shape, spread, level - step)[0],
            )
            np.testing.assert_allclose(slope[:, i], (above - below) / 2e-5, rtol=1e-5, atol=1e-8)


def test_marginal_over_levels_agrees_with_importance_sampling():
    rng = np.random.default_rng(0)
    one = spectra(rng, sources=1, points=12, noise=0.8, spread=0.15)[0]
    log_omega, shape = np.log(2 * np.pi * one.frequency), np.array([*TRUE, 1.0])
    noise = np.full((1, 12), 0.8**2)
    starts = np.array([0, 12])
    value = marginal(one.permittivity, log_omega, starts, shape[None], noise, np.array([0.1]))[0]
    level = rng.standard_normal((60000, 4))
    weights = np.array(
        [-0.5 * np.sum((one.permittivity - curve(log_omega, shape, 0.1, z)[0]) ** 2) / 0.64 for z in level]
    ) - 6 * np.log(2 * np.pi * 0.64)
    assert value == pytest.approx(np.logaddexp.reduce(weights) - np.log(len(weights)), abs=0.15)


def test_recovers_the_truth_with_honest_spread():
    rng = np.random.default_rng(2)
    problem = dielectric_problem(spectra(rng), parameters())
    assert len(problem.priors) <= 6
    found = mode(problem, rng)
    for name, true in zip(NAMES, TRUE, strict=True):
        mean, sd = found[name]
        assert abs(mean - true) < 3.5 * sd, name
    noise, noise_sd = found["spectrum_noise"]
    assert abs(noise - 0.3) < 4 * noise_sd


def test_disagreeing_sources_cost_certainty():
    rng = np.random.default_rng(3)
    close = mode(dielectric_problem(spectra(rng, spread=0.005), parameters()), rng)
    apart = mode(dielectric_problem(spectra(rng, spread=0.12), parameters()), rng)
    assert apart["kappa_static"][1] > 2 * close["kappa_static"][1]


def test_one_source_is_taken_as_the_films_own():
    rng = np.random.default_rng(4)
    problem = dielectric_problem(spectra(rng, sources=1, spread=0.0), parameters())
    assert "source_spread" not in problem.priors.names
    assert any("one source" in note for note in problem.notes)
    assert mode(problem, rng)["kappa_static"][1] < 1.0


def test_weights_leave_out_and_pull():
    rng = np.random.default_rng(5)
    made = spectra(rng)
    problem = dielectric_problem(made, parameters(), weights={"s1": 0.0})
    assert "s1 left out: weight 0" in problem.notes and len(problem.observed) == 50
    assert not dielectric_problem([], parameters()).has_data
    assert not dielectric_problem(made, parameters(), weights={"s0": 0, "s1": 0, "s2": 0}).has_data


def test_havriliak_negami_contains_cole_cole():
    rng = np.random.default_rng(6)
    made = spectra(rng, spread=0.0)
    plain = dielectric_problem(made, parameters())
    wide = plain.wider
    assert wide is not None and wide.wider is None
    theta = plain.priors.sample(rng, 5)
    with_one = np.concatenate([theta, np.ones((5, 1))], axis=1)
    np.testing.assert_allclose(wide.log_likelihood(with_one), plain.log_likelihood(theta), rtol=1e-9)
    mean, sd = mode(wide, rng)["havriliak_negami_exponent"]
    assert abs(mean - 1) < 3 * sd < 0.6
    assert width_check(wide, rng).endswith("stands")


def test_a_spectrum_that_cole_cole_cannot_describe_is_said():
    rng, shape = np.random.default_rng(7), np.array([*TRUE, 0.5])
    frequency = np.geomspace(1e2, 1e8, 40)
    clean = curve(np.log(2 * np.pi * frequency), shape, 0.0, np.zeros(4))[0]
    made = [Spectrum(f"s{i}", frequency, clean + 0.2 * rng.standard_normal(40)) for i in range(2)]
    problem = dielectric_problem(made, parameters())
    assert problem.wider is not None
    assert width_check(problem.wider, rng).endswith("too narrow for these data")
