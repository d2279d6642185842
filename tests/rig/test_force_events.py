"""Where the force itself shows that the voltage fell."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.rig.force_events import find_drop
from rig.made_run import STEP

OFF = 5.0
RELEASE = 0.6e-3  # s that a release takes here


def stick_slip(slip: float, after: float) -> tuple[np.ndarray, np.ndarray]:
    """Time (s) and force (N) of a run that climbs at 9 N/s and slips to ``after`` every 20 ms, the last time ``slip``
    seconds before it is released to 0.03 N at ``OFF``."""
    time = np.arange(4.5, 5.5, STEP)
    since = np.mod(time - (OFF - slip), 0.02)
    top, fallen = after + 9.0 * 0.02, np.clip(since / RELEASE, 0.0, 1.0)
    driven = top + (after - top) * fallen + 9.0 * since * (fallen >= 1.0)
    driven_at_off = after + 9.0 * slip
    released = driven_at_off + (0.03 - driven_at_off) * np.clip((time - OFF) / RELEASE, 0.0, 1.0)
    force = np.where(time < OFF, driven, released)
    return time, force + np.random.default_rng(3).normal(0.0, 0.004, len(time))


@pytest.mark.parametrize("after", [0.1, 0.2])
@pytest.mark.parametrize("slip", [0.003, 0.005, 0.007, 0.010, 0.015])
def test_a_slip_just_before_release_is_not_taken_for_it(slip, after):
    time, force = stick_slip(slip, after)
    drop = find_drop(time, force, SimpleNamespace(off=OFF), 0.02)
    assert drop == pytest.approx(OFF, abs=3.0 * STEP)
