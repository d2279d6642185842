"""The page of the finite-element study."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from eaclutch.records import FieldSolution
from eaclutch.reporting.field_figures import excess_picture, field_picture, insulator_picture
from eaclutch.reporting.study_page import Section, render_study, table_of

CONDUCTOR = {
    "film_permittivity": "film permittivity (1)",
    "gap_um": "air gap (µm)",
    "analytic_pa": "formula (Pa)",
    "finite_element_pa": "finite elements (Pa)",
    "excess_percent": "above the formula (%)",
    "mesh_change_percent": "change by halving the mesh (%)",
    "fringe_length_um": "fringe length (µm)",
}
INSULATOR = {
    "substrate_permittivity": "substrate permittivity (1)",
    "gap_voltage_percent": "gap voltage (% of applied)",
    "pressure_pa": "pressure (Pa)",
    "pressure_over_metal": "pressure over that on metal (1)",
}
LIMIT = 0.05  # the paper's claim for the analytic pressure


def field_page(
    conductor: pd.DataFrame,
    insulator: pd.DataFrame,
    fields: Mapping[str, FieldSolution],
    film_thickness: float,
    gap: float,
    voltage: float,
) -> str:
    """HTML: the analytic pressure against finite elements, insulators, fields."""
    within = conductor["excess"].abs() <= LIMIT
    beyond = conductor[~within]
    verdict = (
        "The analytic pressure lies within 5 % of the field solution in "
        f"{within.sum()} of {len(conductor)} cases."
    )
    if len(beyond):
        cases = ", ".join(
            f"{row.gap_um:g} µm at permittivity {row.film_permittivity:g} ({100 * row.excess:+.1f} %)"
            for row in beyond.itertuples()
        )
        verdict += f" Beyond it: {cases}."
    why = (
        "What the formula leaves out is the strip of film beside each electrode that stays at nearly the electrode's "
        "potential. Its width grows as the square root of permittivity, film thickness and gap (fringe length in the "
        "table), so the excess grows with both permittivity and gap."
    )
    on_metal = conductor.assign(
        excess_percent=100 * conductor["excess"], mesh_change_percent=100 * conductor["mesh_change"]
    )
    on_insulators = insulator.assign(gap_voltage_percent=100 * insulator["gap_voltage_share"])
    sections = [
        Section(
            "Metal substrate", [verdict, why], [excess_picture(conductor)], [table_of(on_metal, CONDUCTOR)]
        ),
        Section(
            "Insulating substrates",
            [],
            [insulator_picture(insulator)],
            [table_of(on_insulators, INSULATOR)],
        ),
        Section("Fields", [], [field_picture(fields, film_thickness, gap)]),
    ]
    lead = f"Two neighbouring electrodes of the pad at {voltage:g} V, film, air gap and substrate in cross-section."
    return render_study("Finite-element check of the pressure", lead, sections)
