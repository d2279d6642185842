"""The finite-element check against limits that are known without it, and its own convergence."""

import numpy as np
import pytest
from scipy.constants import epsilon_0

from eaclutch.studies.finite_elements import CrossSection, solve_field


def test_narrow_gap_and_film_reach_the_plate_limit():
    """With film and gap far thinner than the electrodes, fringes vanish and the plate formula is exact."""
    section = CrossSection(3.0, 1e-6, film_thickness=2e-6)
    field = solve_field(section, 300.0)
    analytic = 9.0 * epsilon_0 * 150.0**2 / (2 * (2e-6 + 3e-6) ** 2)
    assert field.pressure == pytest.approx(analytic, rel=2e-3)
    assert field.substrate_potential == pytest.approx(150.0, rel=1e-6)


def test_pressure_converges_with_the_mesh():
    section = CrossSection(50.0, 5e-6)
    coarse, fine = (solve_field(section, 300.0, n).pressure for n in (1, 2))
    assert abs(coarse / fine - 1) < 5e-4


def test_force_scales_with_the_voltage_squared_and_a_vacuum_substrate_feels_none():
    section = CrossSection(50.0, 10e-6)
    assert solve_field(section, 300.0, 1).pressure == pytest.approx(
        4 * solve_field(section, 150.0, 1).pressure
    )
    metal = solve_field(CrossSection(50.0, 5e-6), 300.0, 1).pressure
    vacuum = solve_field(CrossSection(50.0, 5e-6, substrate_permittivity=1.0), 300.0, 1).pressure
    assert abs(vacuum) < 1e-4 * metal


def test_insulators_hold_little_gap_voltage_and_approach_the_metal():
    fields = [
        solve_field(CrossSection(50.0, 5e-6, substrate_permittivity=k), 300.0, 1) for k in (3.5, 1e3, 1e6)
    ]
    voltages = [field.gap_voltage for field in fields]
    assert voltages == sorted(voltages)
    assert voltages[0] < 0.02 * 300.0
    metal = solve_field(CrossSection(50.0, 5e-6), 300.0, 1)
    assert fields[-1].pressure == pytest.approx(metal.pressure, rel=2e-3)
    assert np.isnan(fields[0].substrate_potential)
