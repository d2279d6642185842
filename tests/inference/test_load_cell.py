"""The load-cell stage: mass and damping follow the swings, the stiffness keeps its prior."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.stages.load_cell import load_cell_problem, swing
from eaclutch.inference.start import starting_walkers
from eaclutch.physics.parameters import base_parameters
from eaclutch.records import Bench, BurstFeatures

PARAMETERS = dict(HYPERPARAMETERS) | base_parameters(Bench("x"), "linear")


def bursts(rng, count=12, stiffness=18018.0, mass=0.00108, damping=0.45):
    frequency, ratio = swing(stiffness, mass, damping)
    return BurstFeatures(
        frequency + rng.standard_normal(count), np.ones(count),
        ratio * (1 + 0.05 * rng.standard_normal(count)), np.full(count, 0.05 * ratio),
    )  # fmt: skip


def posterior(problem, rng):
    start = starting_walkers(problem.log_density, len(problem.priors), 40, rng)
    u = start.mode + rng.standard_normal((4000, len(problem.priors))) @ start.root.T
    return problem.priors.from_normal(u)


def test_swing_of_a_damped_oscillator():
    frequency, ratio = swing(18018.0, 0.0011, 0.43)
    rate = 0.43 / (2 * 0.0011)
    assert frequency == pytest.approx(np.sqrt(18018 / 0.0011 - rate**2) / (2 * np.pi))
    assert ratio == pytest.approx(rate / np.sqrt(18018 / 0.0011))
    assert swing(1.0, 1.0, 10.0)[0] == 0.0  # overdamped: no swing, no NaN


def test_mass_and_damping_are_learnt_and_stiffness_is_not():
    rng = np.random.default_rng(1)
    theta = posterior(load_cell_problem(bursts(rng), PARAMETERS), rng)
    stiffness, mass, damping = theta[:, 0], theta[:, 1], theta[:, 2]
    assert abs(mass.mean() - 0.00108) < 3 * mass.std() and abs(damping.mean() - 0.45) < 3 * damping.std()
    assert damping.std() < 0.4 * 0.05  # prior sd
    assert stiffness.std() > 0.7 * 500  # the prior's, but for what the mass's prior adds
    assert np.corrcoef(stiffness, mass)[0, 1] > 0.9  # only their ratio is measured


def test_no_bursts_no_data():
    empty = BurstFeatures(*(np.zeros(0) for _ in range(4)))
    for nothing in (None, empty):
        problem = load_cell_problem(nothing, PARAMETERS)
        assert not problem.has_data and problem.priors.names == ("stiffness", "mass", "damping")
