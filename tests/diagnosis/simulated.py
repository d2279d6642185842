"""Campaigns that the library simulates itself, small enough to be diagnosed in a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date

import numpy as np

from eaclutch.diagnosis.inputs import DiagnosisInputs
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
        (300, 1000, 5, 0.12), (300, 1000, 2, 0.5), (200, 1000, 2, 0.5), (300, 0.1, 2, 0.12), (300, 1000, 2, 1.0),
    ]
]  # fmt: skip
CANDIDATES = ("series_compliance", "trigger_latency", "substrate_inertia")


def inputs(
    effects: Sequence[str] = (),
    parameters: Mapping[str, float] | None = None,
    seed: int = 4,
    conditions: Sequence[Mapping[str, float]] = CONDITIONS,
    days: int = 2,
    repeats: int = 3,
) -> DiagnosisInputs:
    """What a diagnosis of a simulated campaign starts from; the same seed draws the same noise."""
    rng = np.random.default_rng(seed)
    sessions = [date(2025, 3, 1 + day) for day in range(days)]
    plan = Plan(sweep(conditions, sessions, repeats, rng))
    table = simulate_table(plan, BENCH, (*BASE, *effects), parameters or {}, BenchNoise(), rng)
    return DiagnosisInputs(BENCH, table.runs, table.readings, table.spectra, table.bursts, BASE, CANDIDATES)
