"""The calibrated base parameters: names, units, bounds, defaults and priors for a bench."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from eaclutch.physics.effect import Parameter, Prior
from eaclutch.records import Bench, FloatArray, Gaussian

MultiplierForm = Literal["none", "constant", "linear"]
# The multiplier's level is its value at this voltage, so that level and slope are nearly uncorrelated.
MULTIPLIER_VOLTAGE = 200.0
CONTACT_LAW_BEND = "contact_law_bend"
# A fifth of the way from Gaussian to exponential asperity heights; what departs further is part of the gap.
BEND_SD = 0.15


def _measured(
    name: str, unit: str, value: Gaussian, bounds: tuple[float, float], description: str
) -> Parameter:
    return Parameter(name, unit, bounds, value.mean, Prior("normal", value.mean, value.sd), None, description)


def base_parameters(bench: Bench, form: MultiplierForm) -> dict[str, Parameter]:
    """Parameters of the base model; friction and load cell with the bench's priors. Names are those of the
    posterior files (contract: posterior/<stage>.nc)."""
    friction, cell = bench.friction, bench.load_cell
    thickness = bench.pad.film_thickness
    rows = [
        Parameter("contact_stiffness", "N m^-3.5", (1e10, 1e19), 5.4e14, Prior("lognormal", 6e14, 1.5), None,
                  "Greenwood-Williamson stiffness k"),
        Parameter("roughness_sd", "m", (1e-7, 5e-5), 2.8e-6, Prior("lognormal", 2.8e-6, 0.4), None,
                  "standard deviation of the asperity heights"),
        Parameter(CONTACT_LAW_BEND, "1", (-1.0, 1.5), 0.0, Prior("normal", 0.0, BEND_SD), 0.0,
                  "how far the contact law departs from Greenwood-Williamson's (laws.bent)"),
        Parameter("stray_capacitance", "F", (-1e-10, 1e-10), bench.fixture.stray_capacitance,
                  Prior("normal", bench.fixture.stray_capacitance, 5e-13), None,
                  "parallel capacitance left in the fixture's readings"),
        Parameter("kappa_static", "1", (1.0, 1e4), 54.2, Prior("lognormal", 50.0, 0.3), None,
                  "relative permittivity at low frequency"),
        Parameter("kappa_infinity", "1", (1.0, 100.0), 4.0, Prior("normal", 4.0, 0.5), None,
                  "relative permittivity at high frequency"),
        Parameter("relaxation_time", "s", (1e-10, 1.0), 2.82e-6, Prior("lognormal", 2.8e-6, 0.5), None,
                  "Cole-Cole relaxation time"),
        Parameter("cole_cole_exponent", "1", (0.05, 1.0), 0.562, Prior("normal", 0.56, 0.08), None,
                  "Cole-Cole exponent alpha"),
        Parameter("film_thickness", "m", (1e-7, 1e-3), thickness, Prior("normal", thickness, thickness / 24), None,
                  "thickness of the dielectric film"),
        _measured("stiffness", "N/m", cell.stiffness, (1.0, 1e8), "load cell stiffness"),
        _measured("mass", "kg", cell.mass, (1e-7, 10.0), "load cell effective mass"),
        _measured("damping", "kg/s", cell.damping, (0.0, 1e4), "load cell damping"),
        _measured("film_static", "1", friction.film_static, (1e-3, 5.0), "static friction, strip on film"),
        _measured("film_kinetic", "1", friction.film_kinetic, (1e-3, 5.0), "kinetic friction, strip on film"),
        _measured("base_static", "1", friction.base_static, (1e-3, 5.0), "static friction, strip on base"),
        _measured("base_kinetic", "1", friction.base_kinetic, (1e-3, 5.0), "kinetic friction, strip on base"),
        Parameter("slip_phase", "1", (0.0, 1.0), 0.5, Prior("uniform", 0.0, 1.0), None,
                  "where in its stick-slip cycle a run stands at switch-off (0 after a slip, 1 before the next)"),
    ]  # fmt: skip
    if form != "none":
        rows.append(
            Parameter("force_multiplier_level", "1", (1e-3, 1e3), 1.0, Prior("lognormal", 1.0, 0.1), None,
                      f"force multiplier at {MULTIPLIER_VOLTAGE:g} V; its departure from 1 is part of the gap")
        )  # fmt: skip
    if form == "linear":
        rows.append(
            Parameter("force_multiplier_slope", "1/V", (-0.1, 0.1), 0.0, Prior("normal", 0.0, 1e-3), None,
                      "change of the force multiplier with voltage")
        )  # fmt: skip
    return {row.name: row for row in rows}


def force_multiplier(
    values: Mapping[str, FloatArray], voltage: FloatArray, form: MultiplierForm
) -> FloatArray:
    """lambda_ea(V), broadcast over parameters (draws, 1) and runs."""
    if form == "none":
        return np.ones_like(voltage)
    factor = values["force_multiplier_level"] + np.zeros_like(voltage)
    if form == "linear":
        factor = factor + values["force_multiplier_slope"] * (voltage - MULTIPLIER_VOLTAGE)
    return factor
