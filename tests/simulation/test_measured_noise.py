"""What is measured on simulated recordings is what was put into them."""

from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from eaclutch.physics.effects import BASE
from eaclutch.records import Bench
from eaclutch.rig.campaign import open_campaign
from eaclutch.simulation.campaign import simulate_campaign
from eaclutch.simulation.measured_noise import measure
from eaclutch.simulation.noise import BenchNoise, Line
from eaclutch.simulation.plan import Plan, PlannedRun, RecordTiming, SideBenches


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict:
    folder: Path = tmp_path_factory.mktemp("campaign")
    start = datetime(2025, 3, 3, 14)
    runs = tuple(PlannedRun(start + timedelta(minutes=i), 300.0, 1000.0, 2e-3, 0.1) for i in range(6))
    plan = Plan(
        runs, RecordTiming(1.6, 5e-4, 1.6), SideBenches((), 0, 0, (0.1, 1.0), 0, 0, (1e2, 1e3), 0), ".npy"
    )
    noise = replace(BenchNoise(), white=0.009, mains_amplitude=3e-3, mains_scatter=0.0, line_scatter=0.0,
                    lines=(Line(300.0, 2e-3),), zero_session=0.0, zero_run=0.0, pickup=2e-4, preload_scatter_run=0.0,
                    capacity_scatter_run=0.05, capacity_scatter_slip=0.0)  # fmt: skip
    simulate_campaign(folder, plan, Bench("bench"), BASE, {}, noise, np.random.default_rng(4))
    opened = open_campaign(folder)
    return measure(opened.logs, opened.bench, every=1)


def test_white_noise_and_lines(found: dict):
    assert found["logs"] == 6
    assert found["moving"]["white_sd_n"][1] == pytest.approx(0.009, rel=0.03)
    assert found["still"]["white_sd_n"][1] == pytest.approx(0.009, rel=0.03)
    assert found["moving"]["line_amplitude_n"]["50 Hz"][1] == pytest.approx(3e-3, rel=0.15)
    assert found["moving"]["line_amplitude_n"]["300 Hz"][1] == pytest.approx(2e-3, rel=0.2)
    assert found["still"]["line_amplitude_n"]["300 Hz"][1] < 0.7e-3


def test_pick_up_and_counts(found: dict):
    """Where the ramp of 0.7 mN a sample is small beside it; half the runs begin on the other electrode."""
    assert found["force_count_n"] == pytest.approx(5.07e-5, rel=0.01)
    assert found["voltage_count_v"] == pytest.approx(0.344, rel=0.01)
    if found["pickup_n_per_v"]["first"]:
        assert found["pickup_n_per_v"]["first"][2] == pytest.approx(2e-4, abs=4e-5)
    assert found["pickup_n_per_v"]["falling"][2] > 1e-5 > 0 > found["pickup_n_per_v"]["rising"][2]


def test_scatter_of_repeats(found: dict):
    assert found["repeats"]["groups"] == 1
    assert 0.01 < found["repeats"]["shear_capacity"]["sd_log"] < 0.12
