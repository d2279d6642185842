"""The finite-element study: analytic pressure against the field solution, and insulating substrates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.constants import epsilon_0

from eaclutch.records import FieldSolution, Pad
from eaclutch.studies.finite_elements import CrossSection, solve_field

PERMITTIVITIES = (3.0, 50.0)
GAPS_UM = (1.0, 2.0, 5.0, 10.0, 20.0)
EXAMPLE_GAP = 5e-6  # m
SUBSTRATE_PERMITTIVITIES = (1.0, 2.0, 3.0, 3.51, 4.0, 10.0, 30.0, 100.0, 300.0, 1000.0)


def analytic_pressure(section: CrossSection, voltage: float) -> float:
    """Pressure over the electrodes [Pa] of a flat gap on a floating conductor (Rauf & Follmer 2025, Eq. 4)."""
    film = section.film_thickness / section.film_permittivity
    return epsilon_0 * (voltage / 2) ** 2 / (2 * (film + section.gap) ** 2)


def conductor_table(pad: Pad, voltage: float, refinements: Sequence[int] = (1, 2)) -> pd.DataFrame:
    """Pressure by both ways, a row a (permittivity, gap). ``mesh_change``: finest against next mesh.

    ``fringe_length_um``: sqrt(kappa T_d h), how far the film's potential reaches beside an electrode; what
    the analytic formula leaves out grows with it.
    """
    rows = []
    for permittivity in PERMITTIVITIES:
        for gap_um in GAPS_UM:
            section = CrossSection.of_pad(pad, permittivity, gap_um * 1e-6)
            pressures = [solve_field(section, voltage, level).pressure for level in refinements]
            analytic = analytic_pressure(section, voltage)
            rows.append(
                {
                    "film_permittivity": permittivity,
                    "gap_um": gap_um,
                    "analytic_pa": analytic,
                    "finite_element_pa": pressures[-1],
                    "excess": pressures[-1] / analytic - 1,
                    "mesh_change": abs(pressures[-2] / pressures[-1] - 1),
                    "fringe_length_um": 1e6 * np.sqrt(permittivity * section.film_thickness * section.gap),
                }
            )
    return pd.DataFrame(rows)


def insulator_table(pad: Pad, voltage: float, permittivity: float = 50.0, gap: float = 5e-6) -> pd.DataFrame:
    """Gap voltage and pressure on insulating substrates, a row a substrate permittivity."""
    metal = solve_field(CrossSection.of_pad(pad, permittivity, gap), voltage)
    rows = []
    for substrate in SUBSTRATE_PERMITTIVITIES:
        section = CrossSection.of_pad(pad, permittivity, gap, substrate_permittivity=substrate)
        field = solve_field(section, voltage)
        rows.append(
            {
                "substrate_permittivity": substrate,
                "gap_voltage_share": field.gap_voltage / voltage,
                "pressure_pa": field.pressure,
                "pressure_over_metal": field.pressure / metal.pressure,
            }
        )
    return pd.DataFrame(rows)


def example_fields(pad: Pad, voltage: float, gap: float = EXAMPLE_GAP) -> dict[str, FieldSolution]:
    """Fields to look at: films of permittivity 3 and 50 on metal, and 50 on two insulators."""
    cases: dict[str, tuple[float, float | None]] = {
        "film 3 on metal": (3.0, None),
        "film 50 on metal": (50.0, None),
        "film 50 on an insulator of 3.51": (50.0, 3.51),
        "film 50 on an insulator of 1000": (50.0, 1000.0),
    }
    return {
        name: solve_field(CrossSection.of_pad(pad, film, gap, substrate_permittivity=substrate), voltage)
        for name, (film, substrate) in cases.items()
    }
