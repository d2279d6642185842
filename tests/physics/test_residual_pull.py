"""What a field leaves behind: several causes of it share one residual field."""

import numpy as np
import pytest

from eaclutch.physics.sockets import Sockets


def test_a_pull_that_is_left_is_the_square_of_a_field_and_decays_in_its_time():
    left = Sockets().with_residual_pull(np.array([0.25, 0.0]), 3e-3)
    np.testing.assert_allclose(left.residual_fraction, [0.5, 0.0])
    pull = np.asarray(left.residual_fraction) ** 2 * np.exp(-2 * 3e-3 / np.asarray(left.residual_decay_time))
    np.testing.assert_allclose(pull, [0.25 / np.e, 0.0])


def test_two_causes_leave_no_more_than_all_and_decay_between_their_times():
    charged = Sockets(residual_fraction=np.array([0.6, 0.6, 1.0]), residual_decay_time=1e-3)
    both = charged.with_residual_pull(np.array([0.0, 0.5, 0.5]), 0.05)
    # 0.36 + 0.5 of the 0.64 that is not left yet; 0.36 to 0.32 between ln 1 ms and ln 100 ms
    np.testing.assert_allclose(np.asarray(both.residual_fraction) ** 2, [0.36, 0.68, 1.0])
    assert both.residual_decay_time[0] == 1e-3
    assert both.residual_decay_time[1] == pytest.approx(1e-3 * 100.0 ** (0.32 / 0.68))
    assert both.residual_decay_time[2] == 1e-3
