"""A law that the library lacks is recognised as one quantity that changes with one setting, and stays nameless."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from diagnosis.simulated import CANDIDATES, inputs
from eaclutch.diagnosis.conclude import conclude
from eaclutch.diagnosis.gaussian import log_normal
from eaclutch.diagnosis.modulated import _shapes, modulated_fit
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study


@pytest.fixture(scope="module")
def weakens_at_high_frequency():
    """A campaign whose attraction is a fifth weaker from 1 kHz on: nothing in the library does that."""
    strong, weak = (inputs(parameters={"force_multiplier_level": level}) for level in (1.0, 0.8))
    fast = strong.table["condition"].str.contains("1000Hz|10000Hz")
    table = pd.concat([strong.table[~fast], weak.table[fast]]).sort_index()
    return Study(replace(strong, table=table), load_thresholds(), seed=3)


def test_a_law_that_the_library_lacks_is_described_and_not_named(weakens_at_high_frequency):
    study = weakens_at_high_frequency
    document = conclude(study, [study.weigh(())] + [study.weigh((name,)) for name in CANDIDATES])
    assert document["verdict"]["effects"] == ["unknown"]
    assert "changed with drive frequency" in document["verdict"]["why"]
    capacity = [row for row in document["where"] if row["observable"] == "shear_capacity_n"]
    assert capacity


def test_its_evidence_is_the_average_over_what_may_change(weakens_at_high_frequency):
    """With one size the best law alone cannot give less than the average over all of them, nor more than it alone
    times their number; what it is best at is what a direct evaluation gives."""
    study = weakens_at_high_frequency
    thresholds = dict(study.thresholds) | {"modulated": {"sizes": [0.15], "share": 0.1}}
    plain = replace(study.base.linearised, covariance=study.kernels.total())
    law = modulated_fit(plain, study.base.mode, study.data, thresholds)
    direct = log_normal(law.linearised.w, law.linearised.marginal())
    assert law.setting == "drive frequency" and law.size == 0.15
    assert direct - np.log(500) < law.log_evidence < direct
    assert law.log_evidence > log_normal(plain.w, plain.marginal()) + 10.0


def test_what_is_off_everywhere_alike_is_no_law(weakens_at_high_frequency):
    """A change over a setting adds up to nothing over the runs, voltage and preload are none, readings never change."""
    data = weakens_at_high_frequency.data
    shapes = dict(_shapes(data, weakens_at_high_frequency.thresholds))
    assert {"drive frequency", "width", "run order"} <= set(shapes) and not {"voltage", "preload"} & set(
        shapes
    )
    for shape in shapes.values():
        assert np.allclose(shape.sum(axis=0), 0.0, atol=1e-9) and np.ptp(shape[: data.run_entries]) > 0.5
        assert np.all(shape[data.run_entries :] == 0.0)
