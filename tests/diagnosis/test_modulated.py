"""A law that the library lacks is recognised as one quantity that changes with one setting, and stays nameless."""

from dataclasses import replace
from datetime import date

import numpy as np
import pandas as pd
import pytest

from eaclutch.diagnosis.conclude import conclude
from eaclutch.diagnosis.gaussian import log_normal
from eaclutch.diagnosis.modulated import modulated_fit
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import DiagnosisInputs, Study
from eaclutch.physics.effects import BASE
from eaclutch.records import Bench, Substrate
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.observables import simulate_table
from eaclutch.simulation.plan import Plan, sweep

BENCH = Bench("unit", substrates={"brass": Substrate(8338.5, 0.000726, 0.1, {2e-3: 2e-3, 5e-3: 2.5e-3})})
CONDITIONS = [
    {"voltage_v": v, "frequency_hz": f, "width_mm": w, "preload_n": p}
    for v, f, w, p in [
        (300, 1000, 2, 0.12), (250, 1000, 2, 0.12), (300, 10, 2, 0.12), (250, 10, 2, 0.12), (300, 10000, 2, 0.12),
        (300, 1000, 5, 0.12), (300, 1000, 2, 0.5), (300, 10, 5, 0.12), (300, 100, 2, 0.12), (300, 10, 2, 0.5),
    ]
]  # fmt: skip
CANDIDATES = ("series_compliance", "trigger_latency", "substrate_inertia")


def simulated(level):
    rng = np.random.default_rng(4)
    plan = Plan(sweep(CONDITIONS, [date(2025, 3, 1), date(2025, 3, 2)], 3, rng))
    return simulate_table(plan, BENCH, BASE, {"force_multiplier_level": level}, BenchNoise(), rng)


@pytest.fixture(scope="module")
def weakens_at_high_frequency():
    """A campaign whose attraction is a fifth weaker from 1 kHz on: nothing in the library does that."""
    strong, weak = simulated(1.0), simulated(0.8)
    fast = strong.runs["condition"].str.contains("1000Hz|10000Hz")
    runs = pd.concat([strong.runs[~fast], weak.runs[fast]]).sort_index()
    return Study(
        DiagnosisInputs(BENCH, runs, strong.readings, strong.spectra, strong.bursts, BASE, CANDIDATES),
        load_thresholds(), seed=3,
    )  # fmt: skip


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
    """A parameter that is wrong everywhere is refitted: the change over a setting has no mean."""
    study = weakens_at_high_frequency
    constant = study.base.mode.jacobian @ np.full(len(study.base.mode.u), 0.2)
    plain = replace(study.base.linearised, w=constant, covariance=study.kernels.total())
    law = modulated_fit(plain, study.base.mode, study.data, study.thresholds)
    assert law.log_evidence < log_normal(plain.w, plain.marginal())
