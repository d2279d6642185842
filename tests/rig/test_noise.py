"""Uncertainties of linear estimators from a run's own noise: white noise keeps its share, slow noise is not hidden."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from eaclutch.rig.estimate import Estimate
from eaclutch.rig.noise import Noise
from eaclutch.rig.observables import hold

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
