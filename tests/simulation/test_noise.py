import numpy as np
import pytest

from eaclutch.simulation.noise import QUIET, BenchNoise, Line, counts, disturb

STEP = 78.125e-6


def _disturbed(
    noise: BenchNoise, samples: int = 12_800, voltage=None, drive: float = 0.0, moving=None, zero=0.0
):
    time = STEP * np.arange(samples)
    voltage = np.zeros(samples) if voltage is None else voltage
    moving = np.ones(samples) if moving is None else moving
    return disturb(np.zeros(samples), time, moving, voltage, drive, zero, noise, np.random.default_rng(3))


def _amplitude(force: np.ndarray, frequency: float) -> float:
    """Amplitude of one frequency that fits the record a whole number of times."""
    time = STEP * np.arange(len(force))
    return 2 * abs(np.mean(force * np.exp(-2j * np.pi * frequency * time)))


def test_a_quiet_bench_adds_nothing_but_the_zero():
    np.testing.assert_array_equal(_disturbed(QUIET, zero=0.02), 0.02)


def test_white_noise_and_counts_have_their_figures():
    from dataclasses import replace

    force = _disturbed(replace(QUIET, white=0.01, force_count=5e-5), 40_000)
    assert np.std(force) == pytest.approx(0.01, rel=0.02)
    np.testing.assert_allclose(force / 5e-5, np.round(force / 5e-5), atol=1e-6)
    assert abs(np.corrcoef(force[1:], force[:-1])[0, 1]) < 0.02


def test_mains_and_a_line_that_needs_the_stage():
    from dataclasses import replace

    noise = replace(
        QUIET, mains_amplitude=2e-3, mains_scatter=0.0, lines=(Line(400.0, 1e-3),), line_scatter=0.0
    )
    moving = _disturbed(noise)
    rest = _disturbed(noise, moving=np.zeros(12_800))
    assert _amplitude(moving, 50.0) == pytest.approx(2e-3, rel=0.02)
    assert _amplitude(rest, 50.0) == pytest.approx(2e-3, rel=0.02)
    assert _amplitude(moving, 400.0) > 0.5e-3  # its frequency wanders a little
    assert _amplitude(rest, 400.0) < 0.05e-3


def test_pick_up_follows_the_edges():
    """At 200 V: 28, 14, 6.16 mN from two samples after the first rise; smaller and of both signs later."""
    from dataclasses import replace

    voltage = np.zeros(200)
    voltage[50:80] = 200.0
    voltage[110:140] = 200.0
    noise = replace(QUIET, pickup=0.14e-3, pickup_rising=-0.04e-3, pickup_falling=0.02e-3)
    force = _disturbed(noise, 200, voltage, 200.0)
    np.testing.assert_allclose(force[50:56], [0, 0, 28e-3, 14e-3, 6.16e-3, 0], atol=1e-12)
    np.testing.assert_allclose(force[80:86], [0, 0, 4e-3, 2e-3, 0.88e-3, 0], atol=1e-12)
    np.testing.assert_allclose(force[112:115], [-8e-3, -4e-3, -1.76e-3], atol=1e-12)


def test_a_negative_noise_is_refused():
    with pytest.raises(ValueError, match="white"):
        BenchNoise(white=-1.0)


def test_counts_of_zero_leave_values():
    np.testing.assert_array_equal(counts(np.array([0.1, 0.23]), 0.0), [0.1, 0.23])
