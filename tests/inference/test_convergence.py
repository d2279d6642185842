"""Ensembles as chains: R-hat and ESS see what diagnostics on interleaved walkers hide."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.inference.convergence import Thresholds, autocorrelation_time, diagnose, split_r_hat


def independent(rng, ensembles=4, steps=600, walkers=20, params=2):
    return rng.standard_normal((ensembles, steps, walkers, params))


def test_independent_draws_pass():
    found = diagnose(independent(np.random.default_rng(0)))
    assert found.passed(Thresholds())
    assert found.tau == pytest.approx(1.0, abs=0.2)
    assert found.ess_bulk == pytest.approx(4 * 600 * 20, rel=0.2)


def test_an_ensemble_that_sits_elsewhere_is_seen():
    chain = independent(np.random.default_rng(1))
    chain[2, :, :, 1] += 0.3  # a shift that R-hat on 80 interleaved walkers (sd 1) would call 1.01
    found = diagnose(chain)
    assert found.r_hat[1] > 1.05 > found.r_hat[0]
    assert any("R-hat" in line for line in found.failures(Thresholds()))


def test_an_ensemble_with_another_spread_is_seen():
    chain = independent(np.random.default_rng(2))
    chain[0] *= 1.3
    assert diagnose(chain).r_hat.min() > 1.05


def test_walkers_that_move_together_do_not_count_as_independent():
    rng = np.random.default_rng(3)
    drift = np.zeros((4, 1500, 1, 1))
    for step in range(1, 1500):
        drift[:, step] = 0.98 * drift[:, step - 1] + 0.2 * rng.standard_normal((4, 1, 1))
    chain = drift + 0.5 * rng.standard_normal((4, 1500, 30, 1))
    found = diagnose(chain)
    assert found.ess_bulk[0] < 0.05 * chain.size
    assert not found.passed(Thresholds())


def test_autocorrelation_time_of_a_known_process():
    rng, rho = np.random.default_rng(4), 0.8
    chain = np.zeros((2, 20000, 8, 1))
    for step in range(1, 20000):
        chain[:, step] = rho * chain[:, step - 1] + rng.standard_normal((2, 8, 1))
    assert autocorrelation_time(chain)[0] == pytest.approx((1 + rho) / (1 - rho), rel=0.05)


def test_a_constant_series_is_no_disagreement():
    assert split_r_hat(np.ones((4, 10))) == 1.0
    assert split_r_hat(np.repeat(np.arange(4.0)[:, None], 10, axis=1)) == np.inf
