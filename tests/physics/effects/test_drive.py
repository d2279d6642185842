"""What edges do to the drive, at on and off and at reversals of polarity; the four runs of conftest."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from eaclutch.physics.kernels.drive import edge
from eaclutch.physics.sockets import Sockets


def test_slow_drive_adds_to_the_drive_that_is_there(fill):
    filled = fill(
        "slow_drive", sockets=Sockets(rise_time_constant=4e-6, fall_time_constant=2e-6), resistance=1e5
    )
    np.testing.assert_allclose(filled.rise_time_constant, [7.5e-6, 7.5e-6, 11e-6, 7.5e-6])
    np.testing.assert_allclose(filled.fall_time_constant, [5.5e-6, 5.5e-6, 9e-6, 5.5e-6])


def test_a_current_limit_makes_edges_straight_as_far_as_the_slow_drive_makes_them(fill):
    drive = Sockets(rise_time_constant=4e-6, fall_time_constant=7e-6)
    filled = fill("slow_drive", sockets=drive, resistance=2e5, voltage_exponent=1.0)
    np.testing.assert_allclose(np.asarray(filled.fall_time_constant)[:3], 14e-6)
    np.testing.assert_allclose(np.asarray(filled.edge_straightness)[:3], 0.5)
    np.testing.assert_allclose(fill("slow_drive", sockets=drive, resistance=2e5).edge_straightness, 0.0)
    np.testing.assert_allclose(
        fill("slow_drive", resistance=0.0, voltage_exponent=1.0).edge_straightness, 0.0
    )


@pytest.mark.parametrize("straightness", [0.0, 1e-4, 0.3, 0.7, 1.0])
def test_what_is_left_of_an_edge_follows_its_law(straightness):
    """-du/dt = u^(1 - s) / tau by a general integrator, over nine tenths of its time; at last nothing is left."""
    tau = 2e-5
    ended = np.linspace(0.0, 0.9 * tau, 10)
    law = solve_ivp(
        lambda _, u: -np.maximum(u, 0.0) ** (1.0 - straightness) / tau,
        (0.0, ended[-1]), [1.0], t_eval=ended, rtol=1e-9, atol=1e-12,
    )  # fmt: skip
    left, rate = np.array([edge(tau, straightness, t) for t in ended]).T
    np.testing.assert_allclose(left, law.y[0], rtol=1e-6)
    np.testing.assert_allclose(rate, left ** (1.0 - straightness) / tau, rtol=1e-9)
    assert edge(tau, straightness, 40.0 * tau)[0] < 1e-16


def mean_square(time_constant: float, half: float = 50e-6) -> float:
    """Of the exponential response to a square wave of half period ``half``, over the wave's, by quadrature."""
    t = np.linspace(0.0, half, 200_001)
    v = 1.0 - 2.0 * np.exp(-t / time_constant) / (1.0 + np.exp(-half / time_constant))
    return float(np.trapezoid(v**2, t) / half)


def test_a_slow_drive_costs_what_the_base_does_not_at_reversals(fill, inputs):
    object.__setattr__(inputs.conditions, "frequency", np.full(4, 10e3))
    drive = Sockets(rise_time_constant=4e-6, force_factor=2.0)
    filled = fill("slow_drive", sockets=drive, resistance=3e5, reversal_ratio=1.0)
    expected = 2.0 * mean_square(4e-6 + 3e5 * 35e-12) / mean_square(4e-6)
    np.testing.assert_allclose(np.asarray(filled.force_factor)[0], expected, rtol=1e-8)
    slow_on_and_off = fill("slow_drive", sockets=drive, resistance=3e5, reversal_ratio=1e-4)
    np.testing.assert_allclose(slow_on_and_off.force_factor, 2.0, rtol=1e-4)


def test_edges_at_reversals_may_cost_force_that_dc_keeps(fill, inputs):
    """Nothing by default; at a share of one all that the published rise costs, 15 % at 10 kHz; half of it at a half."""
    object.__setattr__(inputs.conditions, "frequency", np.array([10e3, 0.1, 10.0, 1e3]))
    kept = [mean_square(3.77749278e-6), 1.0, 1.0, mean_square(3.77749278e-6, 0.5e-3)]
    assert kept[0] == pytest.approx(0.85, abs=0.005)
    for share in (0.0, 0.5, 1.0):
        filled = fill(
            "drive_rise_fall", sockets=Sockets(force_factor=2.0), strength=1.0, reversal_share=share
        )
        expected = 2.0 * (1.0 - share * (1.0 - np.array(kept)))
        np.testing.assert_allclose(np.broadcast_to(filled.force_factor, (4,)), expected, rtol=2e-4)
    stepped = fill("drive_rise_fall", strength=0.0, reversal_share=1.0)
    np.testing.assert_allclose(stepped.force_factor, 1.0, rtol=1e-6)
