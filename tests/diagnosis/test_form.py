"""How far the law of a named effect may be off, and of which it may not."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study


def test_a_large_stray_capacitance_is_found_whole():
    """Capacitances in parallel add: a fifth of 8 pF may not pass for another form of that law, which would cost a
    reading of 30 pF more evidence than the effect gains."""
    given = inputs(("stray_capacitance",), {"stray_capacitance.capacitance": 8e-12})
    study = Study(replace(given, candidates=("stray_capacitance", "gap_tilt")), load_thresholds(), seed=3)
    fitted = study.fit(("stray_capacitance",))
    assert np.all(fitted.form == 0.0) and np.any(fitted.signature != 0.0)
    found = study.weigh(("stray_capacitance",))
    assert found.log_evidence > found.log_evidence_without + 15.0  # 9 where a fifth of it may pass
    entry = found.parameters["capacitance"]
    assert entry["mean"] == pytest.approx(8e-12, abs=3 * entry["sd"])
    pair = study.fit(("stray_capacitance", "gap_tilt"))
    assert np.any(pair.form != 0.0)
    assert not np.allclose(pair.form, pair.signature)
