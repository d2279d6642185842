from datetime import datetime

import numpy as np
import pytest

from eaclutch.records import InputError, Recording, RunSettings
from eaclutch.simulation.faults import FAULTS, damage, lose_lines

SETTINGS = RunSettings("run", datetime(2025, 3, 3), 1.5e-3, 5e-4, None, 300.0, 1000.0, 2e-3, "brass")


@pytest.fixture
def recording() -> Recording:
    n = 20_000
    rng = np.random.default_rng(0)
    time = 78e-6 * np.arange(1, n + 1)
    return Recording(SETTINGS, time, 1.2 + 0.01 * rng.standard_normal(n), np.ones(n), rng.normal(2.0, 0.4, n))


def test_without_rates_nothing_happens(recording: Recording):
    same, done = damage(recording, {}, np.random.default_rng(1))
    assert same is recording and done == []


def test_lost_lines_slide_the_rest_and_end_in_zeros():
    np.testing.assert_array_equal(lose_lines(np.array([1.0, 2, 3, 4, 5]), 1, 2), [1, 4, 5, 0, 0])


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_leaves_its_mark(fault: str, recording: Recording):
    hurt, done = damage(recording, {fault: 1.0}, np.random.default_rng(2))
    assert done == [fault]
    mark = {
        "force_shift": lambda: 50 <= np.sum(hurt.force == 0) <= 9000 and np.all(hurt.force[-50:] == 0),
        "voltage_shift": lambda: np.all(hurt.voltage[-50:] == 0),
        "time_tail": lambda: np.all(hurt.time[-12:] == 0) and np.max(np.diff(hurt.time)) > 10 * 78e-6,
        "not_a_number": lambda: 1 <= np.isnan(hurt.force).sum() <= 2,
        "lost_character": lambda: np.sum(np.abs(hurt.force - recording.force) > 0.9) == 1,
        "extra_samples": lambda: len(hurt.time) >= 20_500 and np.all(np.diff(hurt.time) > 0),
    }
    assert mark[fault]()
    untouched = {"time", "force", "flag", "voltage"} - {
        "force_shift": {"force"}, "voltage_shift": {"voltage"}, "time_tail": {"time"}, "not_a_number": {"force"},
        "lost_character": {"force"}, "extra_samples": {"time", "force", "flag", "voltage"},
    }[fault]  # fmt: skip
    for column in untouched:
        np.testing.assert_array_equal(getattr(hurt, column), getattr(recording, column))


def test_an_unknown_fault_is_named(recording: Recording):
    with pytest.raises(InputError, match="gremlins"):
        damage(recording, {"gremlins": 0.5}, np.random.default_rng(3))
