"""A drive that turns its polarity through zero is no gap: what that costs is calibrated with the base model."""

from __future__ import annotations

from diagnosis.simulated import CONDITIONS, inputs
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study

SHARE = "drive_rise_fall.reversal_share"


def test_the_base_model_finds_whether_edges_cost_force_at_reversals():
    fast = [c | {"frequency_hz": f} for c in CONDITIONS[:4] for f in (5000, 10000)]
    conditions = [*CONDITIONS, *fast]
    with_loss, without = (
        Study(inputs(parameters={SHARE: share}, conditions=conditions), load_thresholds()).base
        for share in (1.0, 0.0)
    )
    assert with_loss.parameters[SHARE] > 0.6 > 0.4 > without.parameters[SHARE]
