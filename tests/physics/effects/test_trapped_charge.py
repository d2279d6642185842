"""Trapped charge: how long a polarity lasts, whom the charge weakens, and what a fixed charge leaves."""

import numpy as np


def test_trapped_charge_is_a_low_pass_of_the_drive(fill):
    """Above one over the drive the filled share is 1 / (1 + f / f_c): half at the corner."""
    at_corner = fill("trapped_charge", residual_fraction=0.6, corner_frequency=10.0)
    np.testing.assert_allclose(np.asarray(at_corner.residual_fraction)[2], 0.3)


def test_a_polarity_of_dc_lasts_as_long_as_the_drive(fill, inputs):
    """20 s on 5 s of injection: 4/5, not the half that 0.1 Hz would have filled; at 0.2 Hz it is 2.5 s, a third."""
    object.__setattr__(inputs.conditions, "drive_duration", np.full(4, 20.0))
    object.__setattr__(inputs.conditions, "frequency", np.array([0.1, 0.2, 0.1, 0.1]))
    filled = fill("trapped_charge", residual_fraction=0.5, corner_frequency=0.1)
    np.testing.assert_allclose(np.asarray(filled.residual_fraction)[:2], [0.4, 0.5 / 3.0])


def test_trapped_charge_of_the_electrodes_sign_weakens_the_drive(fill):
    """A third of the field, half of which the driven film feels: 5/6 are left, and 2/5 of these outlive them."""
    filled = fill("trapped_charge", residual_fraction=0.4, corner_frequency=50.0, screening=0.5)
    np.testing.assert_allclose(np.asarray(filled.force_factor)[2], 25 / 36)
    np.testing.assert_allclose(np.asarray(filled.residual_fraction)[2], 0.4)


def test_trapped_charge_may_be_the_same_at_any_voltage(fill):
    """A fixed charge leaves twice the share of the field at half the voltage; 300 and 150 V, same half wave."""
    filled = fill("trapped_charge", residual_fraction=0.3, corner_frequency=50.0, voltage_exponent=-1.0)
    plain = fill("trapped_charge", residual_fraction=0.3, corner_frequency=50.0)
    ratio = np.asarray(filled.residual_fraction) / np.asarray(plain.residual_fraction)
    np.testing.assert_allclose(ratio[:3], [1.0, 1.0, 2.0])
