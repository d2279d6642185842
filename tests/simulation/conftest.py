"""A small bench and a small plan."""

from __future__ import annotations

from datetime import datetime

import pytest

from eaclutch.records import Bench, Substrate
from eaclutch.simulation.plan import Plan, PlannedRun, RecordTiming, SideBenches


@pytest.fixture
def bench() -> Bench:
    return Bench("simulated", substrates={"brass": Substrate(8338.5, 7.26e-4, 0.1, {2e-3: 2e-3, 3e-3: 3e-3})})


@pytest.fixture
def plan() -> Plan:
    """Four short runs in two sessions; one load-cell log, little of the rest."""
    runs = (
        PlannedRun(datetime(2025, 3, 3, 14, 0, 0), 300.0, 1000.0, 2e-3, 0.1),
        PlannedRun(datetime(2025, 3, 3, 14, 1, 0), 300.0, 10.0, 2e-3, 0.1),
        PlannedRun(datetime(2025, 3, 4, 14, 0, 0), 200.0, 0.1, 2e-3, 0.3),
        PlannedRun(datetime(2025, 3, 4, 14, 1, 0), 300.0, 1000.0, 3e-3, 0.1),
    )
    side = SideBenches((2e-3,), 1, 25, (0.1, 4.0), 1, 15, (1e2, 3e6), 1)
    return Plan(runs, RecordTiming(0.7, 1e-4, 0.25), side, ".npy")
