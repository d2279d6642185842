"""From parameters to the data vector, at the ends of what parameters may be."""

import numpy as np
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.forward import _burst_logs
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study


def test_a_load_cell_without_damping_has_a_finite_prediction():
    """A fit may stand at the bound: its bursts are far from those measured, not not-a-number."""
    named = {"stiffness": np.array([18e3]), "mass": np.array([1.1e-3]), "damping": np.array([0.0])}
    frequency, ratio = _burst_logs(named)[0]
    assert np.isclose(np.exp(frequency), np.sqrt(18e3 / 1.1e-3) / (2 * np.pi))
    assert np.isfinite(ratio) and ratio < np.log(1e-3)


@pytest.mark.parametrize(("days", "free"), [(1, 0), (2, 4)])
def test_a_session_drifts_from_others_only(days, free):
    """Two offsets, the share of friction and what static friction does more where there are two sessions; of a single
    one nothing is free."""
    forward = Study(inputs(days=days), load_thresholds()).forward(("session_drift",))
    assert sum(forward.own(name) for name in forward.priors.names) == free
