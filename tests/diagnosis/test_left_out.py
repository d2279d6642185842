"""What a condition's left-out prediction stands on is where a refit would end, not where the slopes point."""

from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.diagnosis.gaussian import Linearised
from eaclutch.diagnosis.result import left_out_errors

SLOPE = np.array([1.0, 2.0, -1.0, 4.0])
ROWS = np.array([3])


def errors(predict, step, values):
    """Of a one-parameter model fitted at u = 0, whose linearised refit without entry 3 stands at u = ``step``."""
    forward = SimpleNamespace(predict=predict, priors=SimpleNamespace(from_normal=lambda u: u))
    mode = SimpleNamespace(u=np.zeros(1), names=("size",))
    fitted = SimpleNamespace(
        mode=mode, residual=values, linearised=Linearised(values, SLOPE[:, None], 0.1**2 * np.eye(4))
    )
    left = SimpleNamespace(groups=(ROWS,), u=np.array([[step]]))
    return left_out_errors(forward, SimpleNamespace(values=values), fitted, left, {})


def test_a_model_that_follows_its_slopes_is_taken_at_the_refit():
    values = SLOPE * 0.8
    found = errors(lambda u: u @ SLOPE[None, :], 0.8, values)
    assert found[3] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(found[:3], values[:3])  # of no group: as they were


def test_a_step_that_the_model_does_not_follow_ends_where_the_others_are_explained_best():
    """Beyond u = 0.5 a run that was on the verge is somewhere else altogether."""

    def bends(u):
        return u @ SLOPE[None, :] + np.where(u > 0.5, 30.0, 0.0)

    found = errors(bends, 0.8, SLOPE * 0.8)
    assert found[3] == pytest.approx(4.0 * (0.8 - 0.4))  # half way, not 30 off


def test_what_a_left_out_entry_says_itself_does_not_choose_its_prediction():
    """Only the entries that stay decide, however well another point would predict the one that is left out."""
    values = SLOPE * 0.8
    values[3] = 0.0  # the start would predict it perfectly
    found = errors(lambda u: u @ SLOPE[None, :], 0.8, values)
    assert found[3] == pytest.approx(-4.0 * 0.8)
