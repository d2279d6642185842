"""What is put in the place of samples that the drive's pick-up spoiled."""

import numpy as np
import pytest

from eaclutch.rig.fall import over_pick_up

STEP = 78.125e-6
TIME = STEP * (np.arange(-8, 60) + 0.5)
SPOILED = (TIME > 1.2 * STEP) & (TIME < 3.8 * STEP)


def swing(quarter: float) -> np.ndarray:
    """A force of 1 N that is let go at 0 and swings, its first zero after ``quarter`` [s]."""
    return np.where(TIME < 0.0, 1.0, np.cos(0.5 * np.pi * TIME / quarter))


def bridged(force: np.ndarray, noise_sd: float = 1e-3) -> np.ndarray:
    spoiled = np.where(SPOILED, 7.0, force)
    return over_pick_up(TIME, spoiled[None], SPOILED, np.ones(1), noise_sd)[0]


def parabola(force: np.ndarray) -> np.ndarray:
    """The bridge without the cubic term, which no noise as large as this would leave."""
    return bridged(force, noise_sd=10.0)


@pytest.mark.parametrize("quarter", [0.25e-3, 0.32e-3])
def test_a_fast_fall_is_followed_where_a_parabola_lags(quarter):
    force = swing(quarter)
    lag = np.abs(parabola(force) - force).max()
    assert lag > 0.1
    assert np.abs(bridged(force) - force).max() < 0.65 * lag


def test_a_slow_fall_keeps_the_parabola():
    force = swing(1.0e-3)
    assert np.array_equal(bridged(force), parabola(force))
    assert np.abs(bridged(force) - force).max() < 0.02


def test_only_spoiled_samples_change():
    force = swing(0.32e-3)
    assert np.array_equal(bridged(force)[~SPOILED], force[~SPOILED])
    assert np.array_equal(over_pick_up(TIME, force[None], SPOILED & False, np.ones(1), 1e-3)[0], force)
