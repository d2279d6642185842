"""The generator's own laws against closed forms, the contract's check values, and another integrator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import erfcx

from eaclutch.blind import contact, film, loadtrain
from eaclutch.blind.world import VACUUM_PERMITTIVITY, Constants, Runs, real_permittivity

PAPER = Constants(
    5.98e14, 2.83e-6, 24e-6, 54.2, 4.0, 2.82e-6, 0.562, 18018.0, 1.1004e-3, 0.4274, 0.281, 0.173, 0.188, 0.154
)


def some_runs(count: int = 4, **changes: object) -> Runs:
    one = np.ones(count)
    voltage = np.linspace(150.0, 300.0, count)
    kappa = real_permittivity(1000.0 * one, 54.2, 4.0, 2.82e-6, 0.562)
    runs = Runs(
        voltage, 1000.0 * one, 2e-3 * one, 2e-3 * one, 0.1 * one, 3.0 * one, 0 * one, 0 * one, 0 * one, kappa,
        24e-6 * one, 0.281 * one, 0.173 * one, 0.188 * one, 0.154 * one,
    )  # fmt: skip
    return replace(runs, **changes) if changes else runs


def test_rough_force_has_the_contracts_check_values() -> None:
    gap = np.array([4e-6, 5e-6, 6e-6, 8e-6])
    mean = contact.rough_average(gap, np.full(4, 24e-6 / 55.5656), 2.70572e-6)
    force = mean * VACUUM_PERMITTIVITY * 28 * 1.5e-3 * 2e-3 * 150**2 / 2
    np.testing.assert_allclose(
        force, [5.33565, 2.97823, 1.51116, 0.34937], rtol=1e-5
    )  # they are printed to six digits


def test_asperity_load_at_touching_planes() -> None:
    # Gamma(5/4) 2^(1/4) / sqrt(pi), the half-normal moment of order 3/2 halved
    assert contact.asperity_load(np.array([0.0]))[0] == pytest.approx(0.430, abs=5e-4)


@pytest.mark.parametrize("law", ["exponential", "fractal"])
def test_other_contact_laws_touch_the_asperities_at_two_sigma(law: str) -> None:
    x = np.array([1.99, 2.0, 2.01])
    own, other = contact.contact_shape(x, law, 0.0), contact.contact_shape(x, law, 1.0)
    assert other[1] == pytest.approx(own[1], rel=1e-9)
    assert np.gradient(np.log(other), x)[1] == pytest.approx(np.gradient(np.log(own), x)[1], rel=1e-3)
    assert not np.allclose(
        contact.contact_shape(np.array([0.5]), law, 1.0), contact.asperity_load(np.array([0.5]))
    )


def test_relaxation_of_order_one_half_is_the_scaled_error_function() -> None:
    x = np.array([0.0, 1e-3, 0.1, 1.0, 10.0, 1e3])
    np.testing.assert_allclose(film.relaxation(x, 0.5), erfcx(np.sqrt(x)), rtol=1e-8)


def test_gap_at_rest_balances_all_forces() -> None:
    runs = some_runs()
    gap, pulled_in = contact.rest_gap(runs, PAPER, runs.voltage, runs.kappa)
    net = contact.held_apart(gap, runs, PAPER) - contact.electric_force(
        gap, runs.voltage, runs.kappa, runs, PAPER
    )
    assert not pulled_in.any()
    np.testing.assert_allclose(net, 0, atol=1e-8)
    assert np.all(np.diff(gap) < 0)  # more voltage, smaller gap


def test_release_of_the_film_agrees_with_an_adaptive_integrator() -> None:
    runs = some_runs(2)
    gap, _ = contact.rest_gap(runs, PAPER, runs.voltage, runs.kappa)
    own = film.release_motion(gap, runs, PAPER)
    falls = np.log(9) / PAPER.fall_90_10

    def speed(time: float, h: np.ndarray) -> np.ndarray:
        left = film.relaxation(np.array(time / PAPER.relaxation_time), PAPER.cole_cole_exponent)
        kappa = PAPER.kappa_infinity + (runs.kappa - PAPER.kappa_infinity) * left
        pull = contact.electric_force(h, runs.voltage * np.exp(-time * falls), kappa, runs, PAPER)
        return (contact.held_apart(h, runs, PAPER) - pull) / film.squeeze_coefficient(h, runs, PAPER)

    times = film.RELEASE_TIMES[[30, 80, 120]]
    reference = solve_ivp(speed, (0, times[-1]), gap, "LSODA", t_eval=times, rtol=1e-8, atol=1e-13).y.T
    way = film.RELEASE_TIMES.searchsorted(times)
    np.testing.assert_allclose(own[way] - gap, reference - gap, rtol=0.03)


def test_the_free_tip_swings_with_the_load_cells_period_and_decay() -> None:
    runs = some_runs(1, base_static=np.zeros(1), base_kinetic=np.zeros(1), film_static=np.zeros(1),
                     film_kinetic=np.zeros(1))  # fmt: skip
    force = loadtrain.swing(np.zeros((len(film.RELEASE_TIMES), 1)), np.array([1.0]), runs, PAPER)[:, 0]
    natural = np.sqrt(PAPER.stiffness / PAPER.mass)
    zeta = PAPER.damping / (2 * np.sqrt(PAPER.stiffness * PAPER.mass))
    wd = natural * np.sqrt(1 - zeta**2)
    time = loadtrain.SWING_STEP * np.arange(len(force))
    expected = np.exp(-zeta * natural * time) * (
        np.cos(wd * time) + zeta / np.sqrt(1 - zeta**2) * np.sin(wd * time)
    )
    np.testing.assert_allclose(force, expected, atol=1e-9)


def test_the_ramp_climbs_at_stiffness_times_speed_and_slips_at_the_static_capacity() -> None:
    runs = some_runs(1)
    quiet = replace(PAPER, static_scatter=0.0)
    one = np.ones(1)
    friction = loadtrain.Friction(0.05 * one, 0.5 * one, 0.4 * one)
    times, forces, slip, _ = loadtrain.climb(
        friction, 0.05 * one, 1e-4 * one, runs, quiet, np.random.default_rng(1)
    )
    assert forces[0].max() == pytest.approx(0.5)
    first = int(np.argmax(forces[0]))
    rate = (forces[0][first] - forces[0][1]) / (times[0][first] - times[0][1])
    assert rate == pytest.approx(PAPER.stiffness * PAPER.stage_speed, rel=1e-9)
    zeta = PAPER.damping / (2 * np.sqrt(PAPER.stiffness * PAPER.mass))
    low = 0.4 - np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)) * 0.1
    assert slip[0] == pytest.approx((0.5 - low) / 0.5)
