"""Uncertainties from a run's own noise: white noise keeps its share, slow noise and vibration lines are not hidden."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from eaclutch.rig.estimate import Estimate
from eaclutch.rig.noise import Noise, noise_of
from eaclutch.rig.observables import hold
from eaclutch.rig.swing import fit_swing
from eaclutch.rig.zero import find_zero

SAMPLES, WINDOW = 3200, 640
WEIGHTS = np.full(WINDOW, 1.0 / WINDOW)


def found(stretch, white_sd):
    return Noise(stretch, white_sd).sd(WEIGHTS)


def test_few_windows_of_white_noise_do_not_make_it_larger():
    """Five independent windows: the larger of the stretch's figure and the white share would be 16 % too large."""
    rng = np.random.default_rng(3)
    sds = [found(stretch, 0.01) for stretch in 0.01 * rng.standard_normal((300, SAMPLES))]
    assert np.mean(sds) == pytest.approx(0.01 / np.sqrt(WINDOW), rel=0.08)


def test_slow_noise_counts():
    """Noise that stays for 50 samples: a mean scatters as many times more as it truly does, less a tenth at most."""
    rng = np.random.default_rng(4)
    decay = np.exp(-1 / 50)
    slow = lfilter([0.01], [1.0, -decay], rng.standard_normal((300, SAMPLES + 500)))[:, 500:]
    truth = np.std(slow[:, :WINDOW] @ WEIGHTS)
    white = 0.01 / np.sqrt(1 - decay**2) * np.sqrt(1 - decay)
    sds = np.array([found(stretch, white) for stretch in slow])
    assert np.sqrt(np.mean(sds**2)) == pytest.approx(truth, rel=0.1)


def test_what_the_drive_adds_to_level_and_peak_alike_is_counted_once(monkeypatch):
    """The start ratio's uncertainty is the scatter of ratios whose level and peak carry one offset of the drive."""
    offset, own, other = 0.02, 0.004, 0.003
    level, top, before, friction, final = 0.5, 0.62, 0.02, 0.12, 0.1
    run = SimpleNamespace(
        switch_off_level=Estimate(level, np.hypot(own, offset)), final_level=Estimate(final, other),
        force_before_on=Estimate(before, other), friction_level=Estimate(friction, other), drive_offset_sd=offset,
    )  # fmt: skip
    monkeypatch.setattr(hold, "peak", lambda _: Estimate(top, np.hypot(own, offset)))
    claimed = hold._start_ratio(run).sd
    rng = np.random.default_rng(5)
    drive = offset * rng.standard_normal(40_000)
    a, b = (value + drive + own * rng.standard_normal(40_000) for value in (level, top))
    c, d, e = (value + other * rng.standard_normal(40_000) for value in (before, friction, final))
    assert claimed == pytest.approx(np.std((a - e) / (b - c + d - e)), rel=0.03)


def test_noise_is_the_same_at_the_ends_of_a_stretch():
    """The trend must not hang on the one noisy sample at its end: means of 10 ms there scatter as anywhere else."""
    rng = np.random.default_rng(6)
    residuals = np.array([noise_of(row, 78.125e-6).residual for row in rng.standard_normal((100, 12_800))])
    first, last = residuals[:, :128].mean(axis=1), residuals[:, -128:].mean(axis=1)
    assert max(np.std(first), np.std(last)) < 1.5 / np.sqrt(128)


def test_a_zero_is_found_whatever_its_first_sample_reads():
    """Half a second without contact, 60 mN of friction after it: five noise sd, in each of a hundred runs."""
    rng, step = np.random.default_rng(7), 78.125e-6
    time = step * np.arange(25_600)
    clean = np.where(time < 0.5, 0.02, 0.08)
    zeros = [find_zero(time, clean + 0.0114 * rng.standard_normal(len(time)), 2.0) for _ in range(100)]
    assert not [zero for zero in zeros if zero.reason]
    assert np.std([(zero.value - 0.02) / zero.sd for zero in zeros]) == pytest.approx(1.0, abs=0.25)


def test_a_vibration_line_beside_the_swing_is_part_of_its_uncertainty():
    """A swing at 310 Hz over a line at 314 Hz whose phase is not known, 60 times: the sd that knows the line covers."""
    rng, step, white, line = np.random.default_rng(8), 78.125e-6, 0.002, 0.004
    time = step * np.arange(333)
    swing = 0.1 * np.exp(-0.01 * 2 * np.pi * 310 * time) * np.cos(2 * np.pi * 310 * time)
    lags = white**2 * (np.arange(333) == 0) + line**2 / 2 * np.cos(2 * np.pi * 314 * time)
    pulls = {"white": [], "known": []}
    for _ in range(60):
        vibration = line * np.cos(2 * np.pi * 314 * time + rng.uniform(0, 2 * np.pi))
        force = swing + vibration + white * rng.standard_normal(333)
        for name, autocovariance in (("white", None), ("known", lags)):
            found = fit_swing(time, force, white, autocovariance)
            pulls[name].append((found.frequency - 310.0) / found.frequency_sd)
    assert np.std(pulls["white"]) > 1.5
    assert 0.6 < np.std(pulls["known"]) < 1.3


def test_a_swing_that_friction_stops_keeps_to_its_uncertainty():
    """A straight envelope, not an exponential one, 0.3 N, 150 times: found apart by noise as far as the sd says."""
    rng, step, white = np.random.default_rng(9), 78.125e-6, 0.01
    time = step * np.arange(333)
    swing = np.clip(0.3 - 80.0 * time, 0.0, None) * np.cos(2 * np.pi * 630 * time)
    truth = fit_swing(time, swing, white)
    lags = white**2 * (np.arange(333) == 0)
    found = [fit_swing(time, swing + white * rng.standard_normal(333), white, lags) for _ in range(150)]
    for name in ("frequency", "damping_ratio"):
        pulls = [(getattr(one, name) - getattr(truth, name)) / getattr(one, f"{name}_sd") for one in found]
        assert 0.85 < np.std(pulls) < 1.15
