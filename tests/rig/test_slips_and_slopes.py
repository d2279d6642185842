"""What slips do to slopes and to the largest slip: the value of the whole force, and how far it may be another's."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.records import Bench
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.extract import extract
from eaclutch.rig.observables.ramp import slope
from eaclutch.rig.observables.slip import rivals_spread
from rig.made_run import Made, make_run

DROP_NOISE = 0.004  # N


def _two_slips(first: float, second: float) -> tuple[np.ndarray, np.ndarray]:
    """Levels before each sample and drops, (samples,): slips of these sizes [N] at forces of 1 N and 0.5 N."""
    level, drops = np.full(2000, 1.0), np.zeros(2000)
    level[1000:] = 0.5
    drops[500:510], drops[1500:1510] = first, second
    return level, drops


def test_a_slip_as_large_at_another_force_widens_the_fraction():
    level, drops = _two_slips(0.2, 0.2)
    # either is the largest: the fraction is 0.2 or 0.4
    assert rivals_spread(level, drops, 19, DROP_NOISE, 0.2) == pytest.approx(0.2 / np.sqrt(2), rel=1e-6)


def test_a_smaller_slip_does_not():
    level, drops = _two_slips(0.2, 0.2 - 8 * DROP_NOISE)
    assert rivals_spread(level, drops, 19, DROP_NOISE, 0.2) < 1e-3


@pytest.mark.parametrize("seed", range(3))
def test_the_slope_of_a_force_that_slips_is_that_of_all_its_samples(seed):
    quiet = Made(frequency=100.0, white=1e-4, mains=0.0, capacity=0.3, hold=0.3)
    recording, on, _ = make_run(quiet, np.random.default_rng(seed))
    since = recording.time - on
    slips = 0.4 * (1.0 - (since / 0.023) % 1.0) * ((since > 0.03) & (since < 0.4))
    recording = replace(recording, force=recording.force + slips)
    inside = (since >= 0.05) & (since < 0.2)
    truth = np.polyfit(since[inside], recording.force[inside], 1)[0]
    found = extract(recording, Bench("test"))
    # that the voltage came within a sample's width is most of the uncertainty of a slope that slips
    assert found["ramp_rate_late_n_s_sd"] < 0.03
    assert abs(found["ramp_rate_late_n_s"] - truth) < 2.5 * found["ramp_rate_late_n_s_sd"]


def test_no_slope_is_read_between_edges_that_leave_hardly_a_sample():
    hidden = np.ones(60, dtype=bool)
    hidden[30] = False
    time = np.arange(60) * 78.125e-6
    run = SimpleNamespace(window=lambda start, end: slice(0, 60), pick_up=hidden, time=time, force=time)
    with pytest.raises(Unusable, match="too_short"):
        slope(run, 0.0, 0.0045)
