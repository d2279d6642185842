"""The paper's side computations, each beside the number that was printed.

Maxwell-Wagner time constants (Supplement S3.1), the two prior-work checks (Sec. 2.1) and what had to be
assumed for them. Source: Rauf & Follmer (2025), doi:10.1016/j.eml.2025.102382.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.constants import epsilon_0

AIR_CONDUCTIVITY = 5e-16  # S/m, the paper's value


@dataclass(frozen=True)
class Claim:
    """One printed number and ours. ``note``: what was assumed, or why the two differ."""

    name: str
    published: float
    ours: float
    unit: str
    note: str

    @property
    def ratio(self) -> float:
        """Ours over the published one."""
        return self.ours / self.published


def maxwell_wagner_time(permittivity: float, conductivity: float, film_thickness: float, gap: float) -> float:
    """Time constant [s] of interfacial polarisation across film and gap (Supplement S3.1)."""
    stored = permittivity * gap + film_thickness
    return epsilon_0 * stored / (conductivity * gap + AIR_CONDUCTIVITY * film_thickness)


def series_gap(capacitance_per_area: float, film_thickness: float, permittivity: float) -> float:
    """Air gap [m] of a parallel-plate pad from its capacitance per area [F/m2] (Supplement S2)."""
    return epsilon_0 / capacitance_per_area - film_thickness / permittivity


def pressure_across_gap(potential: float, film_thickness: float, permittivity: float, gap: float) -> float:
    """Normal pressure [Pa] for the potential difference [V] between electrode and substrate (Eq. 5)."""
    return permittivity**2 * epsilon_0 * potential**2 / (2 * (film_thickness + permittivity * gap) ** 2)


def pressure_bare_film(potential: float, film_thickness: float, permittivity: float) -> float:
    """Normal pressure [Pa] when the air gap is left out (Eq. 6)."""
    return permittivity * epsilon_0 * potential**2 / (2 * film_thickness**2)


def _maxwell_wagner() -> list[Claim]:
    film = {"film_thickness": 24e-6, "permittivity": 50.0, "conductivity": 1e-11}
    polyimide = {"film_thickness": 24e-6, "permittivity": 3.4, "conductivity": 6.7e-16}
    hour = 3600.0
    largest = max(maxwell_wagner_time(gap=gap, **polyimide) for gap in np.geomspace(1e-8, 1e-3, 501)) / hour
    return [
        Claim("Maxwell-Wagner time, 1 um gap", 65.5, maxwell_wagner_time(gap=1e-6, **film), "s", ""),
        Claim("Maxwell-Wagner time, 10 um gap", 46.4, maxwell_wagner_time(gap=10e-6, **film), "s", ""),
        Claim(
            "Maxwell-Wagner time, polyimide, 1 um gap",
            22.0,
            maxwell_wagner_time(gap=1e-6, **polyimide) / hour,
            "h",
            "does not follow from the printed formula with the printed numbers: gaps of 0.01-1000 um give "
            f"at most {largest:.1f} h",
        ),
    ]


def _parallel_plate_pad() -> list[Claim]:
    """Hinchet & Shea's pad: 0.76 nF/cm2 at 150 V. The film follows from the three printed numbers."""
    capacitance, potential = 0.76e-9 / 1e-4, 150.0
    # Printed: gap 610 nm, 7.2 kPa without the gap. Two equations for the film's thickness and permittivity.
    thickness_over_permittivity = epsilon_0 / capacitance - 610e-9
    permittivity = epsilon_0 * potential**2 / (2 * 7.2e3 * thickness_over_permittivity**2)
    thickness = permittivity * thickness_over_permittivity
    gap = series_gap(capacitance, 25e-6, 45.0)
    pressure = pressure_across_gap(potential, 25e-6, 45.0, gap)
    assumed = (
        f"assumed: 25 um film of permittivity 45 (the printed gap and 7.2 kPa imply {thickness * 1e6:.1f} um and "
        f"{permittivity:.1f}) and a friction coefficient of 1"
    )
    return [
        Claim("parallel-plate pad, 0.76 nF/cm2: air gap", 610.0, gap * 1e9, "nm", assumed),
        Claim("parallel-plate pad at 150 V: shear capacity", 73.9, pressure / 1e3, "kPa", assumed),
    ]


def _interdigitated_pad() -> list[Claim]:
    """Berdozzi et al.: 76.9 pF at 1 kV. Film, area and friction are not printed, so nothing is predicted.

    With friction 1 the two printed pressures would imply a permittivity below that of vacuum; with an assumed
    permittivity they imply the rest.
    """
    potential, gap, permittivity = 1000.0 / 2, 9.2e-6, 3.4
    with_gap, without_gap = 2.54e3, 15.3e3
    film_at_unit_friction = np.sqrt(epsilon_0 * potential**2 / (2 * with_gap)) - gap
    permittivity_at_unit_friction = epsilon_0 * potential**2 / (2 * without_gap * film_at_unit_friction**2)
    film = gap / (np.sqrt(without_gap / with_gap * permittivity) - 1)
    thickness = permittivity * film
    friction = with_gap / pressure_across_gap(potential, thickness, permittivity, gap)
    area = 4 * 76.9e-12 * (film + gap) / epsilon_0
    assumed = (
        f"equal by construction: film, area and friction are not printed. Assuming permittivity {permittivity}, "
        f"the printed 2.54 and 15.3 kPa imply a {thickness * 1e6:.1f} um film, {area * 1e4:.1f} cm2 of electrodes and "
        f"a friction coefficient of {friction:.2f}; a coefficient of 1 would imply a permittivity of "
        f"{permittivity_at_unit_friction:.2f}, which is impossible"
    )
    recovered = area * epsilon_0 / (4 * 76.9e-12) - film
    capacity = friction * pressure_across_gap(potential, thickness, permittivity, recovered)
    return [
        Claim("interdigitated pad, 76.9 pF: air gap", 9.2, recovered * 1e6, "um", assumed),
        Claim("interdigitated pad at 1 kV: shear capacity", 2.54, capacity / 1e3, "kPa", assumed),
    ]


def side_claims() -> list[Claim]:
    """All side computations, in the paper's order."""
    return _parallel_plate_pad() + _interdigitated_pad() + _maxwell_wagner()


def claims_table(groups: Mapping[str, Sequence[Claim]]) -> pd.DataFrame:
    """All claims as one table: group, quantity, printed, ours, ratio, unit, note."""
    rows = [
        (group, claim.name, claim.published, claim.ours, claim.ratio, claim.unit, claim.note)
        for group, claims in groups.items()
        for claim in claims
    ]
    return pd.DataFrame(rows, columns=["group", "quantity", "printed", "ours", "ratio", "unit", "note"])


# Engagement and release times in the literature [s]; NaN = not measured (Supplement, Table S1).
LITERATURE_TIMES: dict[str, tuple[float, float]] = {
    "Rauf & Follmer 2025": (1.50e-5, 8.75e-4),
    "Hinchet 2020": (5.00e-3, 1.50e-2),
    "Diller 2018": (7.23e-3, 2.36e-2),
    "Krimsky 2024": (2.40e-2, 3.00e-2),
    "Li 2023": (1.55e-2, 4.35e-2),
    "Wei 2023": (5.00e-2, 3.70e-2),
    "Yoder 2023": (5.00e-2, 7.00e-2),
    "Nakamura 2017": (1.04e-2, 1.62e-1),
    "Li 2021": (2.50e-2, 3.24e-1),
    "Thilakarathna 2024": (2.70e-1, 2.70e-1),
    "Cacucciolo 2022": (3.00e-1, 3.00e-1),
    "Mastrangelo 2023": (4.19e-1, 3.28e-1),
    "Hinchet 2022": (np.nan, 6.50e-2),
    "Cao 2019": (np.nan, 1.01e-1),
    "Cacucciolo 2019": (np.nan, 1.50e-1),
    "Chen 1992": (2.00e-1, 1.00e1),
    "Jeon 1998": (2.83e-2, 1.37e1),
    "Chen 2022": (np.nan, 5.00e0),
    "Gao 2019": (np.nan, 3.60e1),
    "Fitch 1957": (1.50e-4, np.nan),
    "Zhang 2019": (6.70e-3, np.nan),
}
