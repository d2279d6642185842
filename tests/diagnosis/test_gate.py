"""One family-wise error rate for a whole table."""

import numpy as np

from eaclutch.diagnosis.gate import adequacy, max_statistic, simulate_null
from eaclutch.diagnosis.gaussian import Linearised, leave_out


def test_family_wise_error_of_the_maximum_statistic():
    rng = np.random.default_rng(5)
    null = rng.chisquare(2, size=(400, 30)) * np.geomspace(1, 100, 30)
    alarms = 0
    for _ in range(300):
        measured = rng.chisquare(2, size=30) * np.geomspace(1, 100, 30)
        alarms += np.min(max_statistic(measured, null)) <= 0.05
    # 300 draws at 5 %: mean 15, sd 3.8
    assert 3 <= alarms <= 30


def test_a_block_that_is_off_is_found_and_the_other_is_not():
    rng = np.random.default_rng(8)
    size = 40
    blocks = np.array(["ramp"] * 20 + ["release"] * 20, dtype=object)
    jacobian = rng.normal(size=(size, 2)) * 0.1
    covariance = np.diag(np.full(size, 0.04))
    w = rng.normal(0, 0.2, size)
    w[20:] += rng.choice([-0.8, 0.8], 20)
    fit = Linearised(w, jacobian, covariance)
    left = leave_out(fit, [np.array([i, 39 - i]) for i in range(20)])
    p, by_block = adequacy(fit, left, blocks, simulate_null(fit, covariance, rng, 300))
    assert p < 0.01
    assert by_block["release"] < 0.01 < by_block["ramp"]
