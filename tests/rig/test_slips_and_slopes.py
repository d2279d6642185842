"""What slips do to slopes and to the largest slip: the value of the whole force, and how far it may be another's."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.records import Bench
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.extract import extract
from eaclutch.rig.fall import passing_times
from eaclutch.rig.noise import Noise
from eaclutch.rig.observables import OBSERVABLES, hold
from eaclutch.rig.observables.ramp import slope
from eaclutch.rig.zero import NO_ZERO
from rig.made_run import Made, make_run, release_time

KNOWN = Estimate(0.0, 0.0)


def _two_slips(first: float, second: float, zero: Estimate = KNOWN) -> Estimate:
    """Slips of these sizes [N] at forces of 1 N and 0.5 N, every other sample seeing the first 4 mN larger."""
    force = np.interp(np.arange(4000), [2000, 3000], [1.0, 0.5 + first])
    force[1000:] -= first + 0.004 * np.tile([1, -1], 1500)
    force[3500:] -= second
    noise = Noise(1e-3 * np.random.default_rng(4).standard_normal(4000), 1e-3)
    run = SimpleNamespace(
        require_unbroken_hold=lambda: None,
        off_doubt=0.0, window=lambda start, end, least: slice(0, 4000), force=force,
        events=SimpleNamespace(on=0.0, off=1.0), zero=zero, step=78.125e-6, noise_moving=noise,
    )  # fmt: skip
    return OBSERVABLES["slip_fraction"].measure(run)


def test_two_slips_as_large_at_different_forces_widen_the_fraction():
    found = _two_slips(0.2, 0.2)
    # each half of the samples takes another one for the largest: 0.2 of 1 N or of 0.5 N
    assert found.value == pytest.approx(0.3, abs=0.01)
    assert found.sd == pytest.approx(0.1, abs=0.01)


def test_a_smaller_slip_does_not():
    found = _two_slips(0.2, 0.15)
    assert found.value == pytest.approx(0.2, abs=0.002)
    assert found.sd < 1e-3


def test_a_zero_that_the_run_does_not_show_widens_the_fraction():
    known, unknown = _two_slips(0.2, 0.15), _two_slips(0.2, 0.15, NO_ZERO)
    assert unknown.value == known.value
    assert unknown.sd_zero_known == known.sd == known.sd_zero_known
    # 0.2 of a force of 1 N that may be 25 mN off
    assert unknown.sd == pytest.approx(0.2 * 0.025, rel=0.02)


def _slipping(drop: float, period: float, seed: int) -> dict:
    """The row of a run that slips by ``drop`` [N] from 0.5 N every ``period`` [s]."""
    quiet, fall = Made(frequency=0.1, capacity=0.5, hold=0.5, ramp=50.0, friction=0.0, final=0.0), 0.8e-3
    recording, on, off = make_run(quiet, np.random.default_rng(seed))
    phase = (recording.time - on) % period
    slipping = 0.5 * (1.0 - np.cos(np.pi * phase / fall))
    below = drop * np.where(phase < fall, slipping, (period - phase) / (period - fall))
    driven = (recording.time > on + period * round(0.05 / period)) & (recording.time < off)
    return extract(replace(recording, force=recording.force - np.where(driven, below, 0.0)), Bench("test"))


@pytest.mark.parametrize(("drop", "period"), [(0.2, 0.03), (0.08, 0.01), (0.2, 0.0075)])
def test_a_slip_is_measured_from_its_top_to_its_bottom_though_the_force_climbs_all_the_while(drop, period):
    rows = [_slipping(drop, period, seed) for seed in range(6)]
    value, sd = np.mean([(r["slip_fraction"], r["slip_fraction_sd_zero_known"]) for r in rows], axis=0)
    assert value == pytest.approx(drop / 0.5, abs=0.012) and sd < 0.03


@pytest.mark.parametrize("period", [0.0022, 0.003, 0.0045])
def test_slips_that_crowd_have_no_size(period):
    row = _slipping(0.2, period, 0)
    assert np.isnan(row["slip_fraction"]) and "slip_fraction:slips_crowded" in row["reasons"]


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


def test_a_spike_after_a_fall_that_ends_at_once_is_no_part_of_it():
    """A tip that sticks as it arrives stands a tenth of its way below the level of nine tenths: noise touches it."""
    time = 78.125e-6 * np.arange(-8, 200)
    force = np.interp(time, [0.0, 0.8e-3, 3e-3], [1.0, 0.03, 0.0])  # and creeps on
    force[np.searchsorted(time, 1.6e-3)] = 0.15
    (found,) = passing_times(time, force[None], np.array([0.1]), np.array([0.1]), near_end=True)
    assert found == pytest.approx(0.742e-3, abs=0.02e-3)


def test_the_time_of_nine_tenths_is_that_of_the_fall_where_noise_touches_its_level_again():
    made = Made(white=0.004)
    recording, _, off = make_run(made, np.random.default_rng(3))
    after = recording.time - off
    # a hair above the last level at first, and one spike
    force = recording.force + np.where(after > 0.9e-3, 0.04 * np.exp(-np.maximum(after, 0.0) / 4e-3), 0.0)
    force[np.searchsorted(after, 1.7e-3) : np.searchsorted(after, 1.95e-3)] += 0.10
    row = extract(replace(recording, force=force), Bench("test"))
    assert row["release_time_90_s"] == pytest.approx(
        release_time(made, 0.9), abs=4 * row["release_time_90_s_sd"]
    )


def test_a_creep_ends_where_the_voltage_is_surely_on(monkeypatch):
    monkeypatch.setattr(hold, "slope", lambda run, start, end: (start, end))
    monkeypatch.setattr(hold, "slips_between", lambda run, start, end: False)
    run = SimpleNamespace(
        require_unbroken_hold=lambda: None, off_doubt=0.002, events=SimpleNamespace(off=2.0, stage_stop=0.5)
    )
    assert OBSERVABLES["hold_creep_n_s"].measure(run) == pytest.approx((1.698, 1.998))


@pytest.mark.parametrize(
    ("slip", "creep", "flagged"), [(0.06, 0.0, True), (0.0, -0.3, False), (0.0, 0.0, False)]
)
def test_a_slip_while_the_stage_rests_is_said_and_a_creep_is_none(slip, creep, flagged):
    """The slope is of the whole force either way, as defined."""
    quiet = Made(frequency=0.4, capacity=0.5, hold=0.5)
    for seed in range(4):
        recording, _, off = make_run(quiet, np.random.default_rng(seed))
        held = (recording.time > off - 0.4) & (recording.time < off)
        lost = slip * (recording.time > off - 0.1) - creep * (recording.time - off + 0.4)
        row = extract(replace(recording, force=recording.force - np.where(held, lost, 0.0)), Bench("test"))
        assert ("slips_at_rest" in row["flags"].split(";")) == flagged
        # a step a third of the window before its end has six times a third of two thirds of its height a window
        slope = -slip / 0.3 * 6 * (1 / 3) * (2 / 3) + creep
        assert row["hold_creep_n_s"] == pytest.approx(slope, abs=5 * row["hold_creep_n_s_sd"])
