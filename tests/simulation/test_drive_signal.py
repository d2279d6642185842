import numpy as np
import pytest

from eaclutch.records import Drive
from eaclutch.simulation.drive_signal import clock, half_wave, sensed_voltage
from eaclutch.simulation.noise import BenchNoise

NOISE = BenchNoise(voltage_white=0.0, voltage_offset=0.0)


def _sensed(frequency: float, seed: int = 0, off: float = 0.03):
    time = np.arange(0, 0.05, 78.125e-6)
    rng = np.random.default_rng(seed)
    return time, sensed_voltage(time, 0.01, off, 300.0, frequency, Drive(), NOISE, rng)


def test_clock_counts_whole_microseconds_at_12800_hz():
    time = clock(2.0, 78.125e-6, np.random.default_rng(1))
    ticks = time * 1e6
    np.testing.assert_allclose(ticks, np.round(ticks), atol=1e-6)
    assert set(np.round(np.diff(ticks)).astype(int)) == {78, 79}
    assert np.mean(np.diff(time)) == pytest.approx(78.125e-6, rel=1e-4)
    assert 1.9 < time[-1] < 2.0


def test_direct_voltage_stands_from_on_to_off():
    time, voltage = _sensed(0.1)
    inside = (time > 0.0101) & (time < 0.03)
    np.testing.assert_allclose(voltage[inside], 300.0, atol=0.2)
    assert np.all(voltage[(time < 0.01) | (time > 0.0301)] == 0)


@pytest.mark.parametrize("seed", range(4))
def test_square_wave_is_there_half_the_time_and_starts_on_either_electrode(seed: int):
    time, voltage = _sensed(1000.0, seed)
    inside = (time > 0.01) & (time < 0.03)
    assert np.mean(voltage[inside] > 150) == pytest.approx(0.5, abs=0.02)
    rises = np.sum(np.diff((voltage > 150).astype(int)) == 1)
    assert rises == 20


def test_both_electrodes_come_first_now_and_then():
    first = {bool(_sensed(100.0, seed)[1][140] > 150) for seed in range(12)}
    assert first == {True, False}


def test_counts_of_the_divider():
    _, voltage = _sensed(1000.0)
    np.testing.assert_allclose(voltage / 0.344, np.round(voltage / 0.344), atol=1e-6)


def test_the_driver_finishes_its_half_wave():
    assert half_wave(10.0) == pytest.approx(0.05)
    assert half_wave(0.1) == 0.0
