"""What a linearised fit promises counts only as far as the model keeps it."""

from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.diagnosis.evidence import unrealised
from eaclutch.diagnosis.gaussian import Linearised

SLOPE = np.array([[1.0], [2.0], [-1.0]])
NOISE = 0.1**2 * np.eye(3)


def fit_at_zero(predict, values):
    """A fit that stopped at u = 0 of a model with one parameter."""
    forward = SimpleNamespace(predict=predict, priors=SimpleNamespace(from_normal=lambda u: u))
    mode = SimpleNamespace(u=np.zeros(1), predicted=np.zeros(3))
    return forward, SimpleNamespace(values=values), mode, Linearised(values, SLOPE, NOISE)


def test_a_model_that_is_as_straight_as_its_slopes_keeps_all_it_promises():
    values = SLOPE[:, 0] * 0.8
    assert unrealised(*fit_at_zero(lambda u: u @ SLOPE.T, values)) == pytest.approx(0.0, abs=1e-9)


def test_a_step_that_brings_nothing_counts_nothing():
    values = SLOPE[:, 0] * 0.8
    lost = unrealised(*fit_at_zero(lambda u: np.zeros((len(u), 3)), values))
    misfit = 0.5 * float(values @ values) / 0.1**2
    kept_by_the_line = 0.5 * float(values @ np.linalg.solve(NOISE + SLOPE @ SLOPE.T, values))
    assert lost == pytest.approx(misfit - kept_by_the_line)


def test_half_of_a_promise_counts_where_the_model_saturates_on_the_way():
    values = SLOPE[:, 0] * 0.8
    straight = unrealised(*fit_at_zero(lambda u: np.zeros((len(u), 3)), values))
    saturating = unrealised(*fit_at_zero(lambda u: np.minimum(u, 0.4) @ SLOPE.T, values))
    assert 0.0 < saturating < 0.5 * straight
