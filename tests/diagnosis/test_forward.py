"""From parameters to the data vector, at the ends of what parameters may be."""

import numpy as np

from eaclutch.diagnosis.forward import _burst_logs


def test_a_load_cell_without_damping_has_a_finite_prediction():
    """A fit may stand at the bound: its bursts are far from those measured, not not-a-number."""
    named = {"stiffness": np.array([18e3]), "mass": np.array([1.1e-3]), "damping": np.array([0.0])}
    frequency, ratio = _burst_logs(named)[0]
    assert np.isclose(np.exp(frequency), np.sqrt(18e3 / 1.1e-3) / (2 * np.pi))
    assert np.isfinite(ratio) and ratio < np.log(1e-3)
