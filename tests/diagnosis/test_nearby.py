"""A fit that ended before a jump: draws around it see what slopes do not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.diagnosis.nearby import nearby

NAMES = ("stiffness", "late.size", "late.decay")


def _forward(jump: float) -> SimpleNamespace:
    """Twelve entries: a line in the stiffness and the size, and a ``jump`` where the decay is beyond 0.4."""

    def predict(theta: np.ndarray) -> np.ndarray:
        theta = np.atleast_2d(theta)
        line = theta[:, :1] * np.linspace(0.0, 1.0, 12) + theta[:, 1:2] * np.linspace(1.0, -1.0, 12)
        return line + jump * (theta[:, 2:] > 0.4) * (np.arange(12) >= 8)

    return SimpleNamespace(
        priors=SimpleNamespace(names=NAMES, from_normal=np.asarray), predict=predict,
        own=lambda name: name.startswith("late."),
    )  # fmt: skip


def _ended(u: np.ndarray) -> SimpleNamespace:
    jacobian = np.stack([np.linspace(0.0, 1.0, 12), np.linspace(1.0, -1.0, 12), np.zeros(12)], axis=1)
    return SimpleNamespace(
        mode=SimpleNamespace(u=u, jacobian=jacobian), linearised=SimpleNamespace(covariance=0.01 * np.eye(12))
    )


@pytest.mark.parametrize("stiffness", [0.0, 0.7])
def test_a_jump_that_slopes_do_not_see_is_found_and_what_is_calibrated_follows(stiffness):
    forward = _forward(0.5)
    data = SimpleNamespace(values=forward.predict(np.array([stiffness, 0.5, 0.6]))[0])
    (start,) = nearby(forward, data, _ended(np.array([0.0, 0.5, 0.0])))
    assert start[2] > 0.4 and start[1] == pytest.approx(0.5, abs=0.3)
    assert start[0] == pytest.approx(stiffness, abs=0.3)


def test_a_fit_that_ended_well_is_left_where_it_is():
    forward = _forward(0.5)
    end = np.array([0.7, 0.5, 0.6])
    assert nearby(forward, SimpleNamespace(values=forward.predict(end)[0]), _ended(end)) == []
