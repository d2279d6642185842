"""The paper's numbers, ours beside them: from the runs by both definitions, and from the calibrated model.

Source: Rauf & Follmer (2025), Secs. 3-5 and Supplement S6-S8, doi:10.1016/j.eml.2025.102382.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.physics import laws
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.published import CONTACT_STIFFNESS, ROUGHNESS, published_release
from eaclutch.records import Bench, FloatArray, RunConditions
from eaclutch.studies.claims import Claim
from eaclutch.studies.sweep import Design, design_conditions
from eaclutch.studies.trends import HALF_POWER, bandwidth, force_exponents, slope

NARROW_MM, LOW_PRELOAD_N = 2.0, 0.25
PART = "the paper has 311 runs, this campaign {n} that the published definitions keep"


def largest_forces(runs: pd.DataFrame, published: pd.DataFrame) -> pd.DataFrame:
    """The runs that the published definitions keep, their capacity replaced by the largest force of the record."""
    kept = published[published["kept"].astype(str).str.lower() == "true"]
    joined = runs.merge(kept, on="run", suffixes=("", "_published"))
    return joined.assign(shear_capacity_n=joined["force_max_n"])


def run_claims(runs: pd.DataFrame, published: pd.DataFrame) -> list[Claim]:
    """Numbers that come from the recordings: runs.csv and runs_published.csv."""
    kept = published[published["kept"].astype(str).str.lower() == "true"]
    note = PART.format(n=len(kept))
    exponents = force_exponents(largest_forces(runs, published))["exponent"]
    told = (
        f"largest force of the record, as the paper takes it; scatter {exponents.std():.3f} (the paper 0.309). The "
        f"capacity less the friction before gives {force_exponents(runs)['exponent'].mean():.2f}"
    )
    at_1khz = (runs["frequency_hz"] == 1000) & (runs["preload_n"] < LOW_PRELOAD_N)
    by_voltage = at_1khz & (runs["width_mm"] == NARROW_MM)
    by_width = (runs["frequency_hz"] == 1000) & (runs["voltage_v"] == 300) & (runs["preload_n"] < 0.5)
    ms, us = kept["release_90_ms"], kept["engagement_us"]
    rows = [
        ("exponent of force over voltage, mean over frequencies", 1.605, exponents.mean(), "1",
         told if len(exponents) else "takes three voltages or more at a drive frequency"),
        ("release time, mean", 1.13, ms.mean(), "ms", note),
        ("release time, sd", 0.36, ms.std(), "ms", note),
        ("runs released within 1 ms", 39.5, 100 * (ms < 1).mean(), "%", note),
        ("10 % release time, mean", 286.0, 1e3 * kept["release_10_ms"].mean(), "us", note),
        ("10 % release time, median", 156.0, 1e3 * kept["release_10_ms"].median(), "us", note),
        ("engagement time, mean", 4.78, us.mean(), "us",
         f"{note}; this statistic cannot resolve microseconds (docs/observables.md)"),
        ("engagement time, sd", 7.07, us.std(), "us", note),
        ("release over voltage, measured slope", -0.72,
         1e6 * slope(runs, "voltage_v", "release_time_90_s", by_voltage)[0], "us/V", "our release time"),
        ("release over width, measured slope", 143.5,
         1e6 * slope(runs, "width_mm", "release_time_90_s", by_width)[0], "us/mm", "our release time, preload < 0.5 N"),
    ]  # fmt: skip
    return [Claim(name, value, float(ours), unit, text) for name, value, ours, unit, text in rows]


@dataclass(frozen=True)
class DesignCurves:
    """The model at one parameter set around the design point, every run from the design's start ratio."""

    model: ClutchModel
    parameters: Mapping[str, FloatArray]
    design: Design

    def conditions(self, **levels: FloatArray) -> RunConditions:
        """Runs at the levels, (runs,) each, with the force at which their release starts."""
        grid = {name: np.atleast_1d(x) for name, x in levels.items()}
        runs = design_conditions(self.model.bench, self.design, grid)
        force = self.model.predict(runs, self.parameters, ["shear_capacity_n"]).values["shear_capacity_n"][0]
        return replace(runs, switch_off_force=self.design.start_ratio * (force + runs.friction_before))

    def __call__(self, observable: str, **levels: FloatArray) -> FloatArray:
        """The observable over the levels, (runs,), SI."""
        runs = self.conditions(**levels)
        return self.model.predict(runs, self.parameters, [observable]).values[observable][0]

    def largest_force(self, frequency: FloatArray) -> FloatArray:
        """Capacity with the friction before [N] over the drive frequency [Hz]."""
        before = self.conditions(frequency_hz=frequency).friction_before
        return self("shear_capacity_n", frequency_hz=frequency) + before


def model_claims(curves: DesignCurves) -> list[Claim]:
    """Numbers that come from the model at one parameter set."""
    voltages, widths = np.linspace(125, 300, 15), np.linspace(2, 6, 9)
    start = "the released scripts stop at the first velocity zero and start from one minus the start ratio"
    way = "way and pull of the film grow together; the printed slope is as small"
    rows = [
        ("-3 dB bandwidth of the capacity", 13.3,
         1e-3 * bandwidth(curves.largest_force), "kHz",
         "half the largest force, friction before included; 1/sqrt(2) of it is reached at "
         f"{1e-3 * bandwidth(curves.largest_force, HALF_POWER):.1f} kHz"),
        ("release over voltage, model slope", -0.25,
         1e6 * _slope(voltages, curves("release_time_90_s", voltage_v=voltages)), "us/V", start),
        ("release over width, model slope", 142.3,
         1e6 * _slope(widths, curves("release_time_90_s", width_mm=widths)), "us/mm", start),
        ("engagement over voltage, model slope", -0.0012,
         1e6 * _slope(voltages, curves("engagement_time_s", voltage_v=voltages)), "us/V", way),
        ("engagement over width, model slope", 0.98,
         1e6 * _slope(widths, curves("engagement_time_s", width_mm=widths)), "us/mm",
         "squeeze film: damping grows with the width cubed, the pull with the width"),
    ]  # fmt: skip
    return [Claim(name, value, float(ours), unit, text) for name, value, ours, unit, text in rows]


def preset_claims(bench: Bench, start_ratio: float) -> list[Claim]:
    """The paper's model numbers with its own parameters, by the choices of its released scripts where they matter."""
    voltages, widths = np.array([100.0, 200.0, 300.0]), np.array([2.0, 4.0, 6.0])
    preload = Design("").preload_n

    def slope_over(levels: FloatArray, runs: list[tuple[float, float]]) -> float:
        times = [published_release(v, 1e-3 * w, 2e-3, preload, start_ratio).release_time for v, w in runs]
        return 1e6 * _slope(levels, np.array(times))

    fitted = {"contact_stiffness": np.array([CONTACT_STIFFNESS]), "roughness_sd": np.array([ROUGHNESS])}
    substrate = sorted(bench.substrates)[0]
    curves = DesignCurves(ClutchModel(bench), fitted, Design(substrate, start_ratio=start_ratio))
    whole = 1e-3 * bandwidth(curves.largest_force)
    capacity = 1e-3 * bandwidth(lambda frequency: curves("shear_capacity_n", frequency_hz=frequency))
    film, sigma = bench.pad.film_thickness / 54.2, ROUGHNESS
    ratio = laws.roughness_average(sigma, film, sigma, 0.83) * (film + sigma) ** 2
    note = (
        f"start ratio {start_ratio:g}, the paper's for its sweeps; its two slopes come out at 0.85 and 0.75"
    )
    rows = [
        ("-3 dB bandwidth of the capacity", 13.3, capacity, "kHz",
         f"half the capacity; with the friction before it is {whole:.1f} kHz, and which is meant is not printed"),
        ("release over voltage, model slope", -0.25, slope_over(voltages, [(v, 2.0) for v in voltages]), "us/V", note),
        ("release over width, model slope", 142.3, slope_over(widths, [(300.0, w) for w in widths]), "us/mm", note),
        ("rough over flat force at a gap of one roughness", 11.1, ratio, "1", "cut at 0.83 of film over permittivity"),
        ("polarisation 100 us after a step", 93.0,
         100 * step_response(np.array([1e-4]))["share"].iloc[0], "%", "with the published 2.82 us and 0.562"),
    ]  # fmt: skip
    return [Claim(name, value, float(ours), unit, text) for name, value, ours, unit, text in rows]


def force_over_frequency(curves: DesignCurves) -> pd.DataFrame:
    """Largest force over the drive frequency, 10 Hz to 1 MHz."""
    frequency = np.geomspace(10, 1e6, 61)
    return pd.DataFrame({"frequency_hz": frequency, "force_n": curves.largest_force(frequency)})


def step_response(time: FloatArray) -> pd.DataFrame:
    """Share of the final polarisation after ``time`` [s], with the published Cole-Cole parameters."""
    return pd.DataFrame(
        {"time_s": time, "share": [1 - laws.mittag_leffler(0.562, t / 2.82e-6) for t in time]}
    )


def _slope(x: FloatArray, y: FloatArray) -> float:
    finite = np.isfinite(y)
    return float(np.polyfit(x[finite], y[finite], 1)[0]) if finite.sum() >= 2 else float("nan")


def medians(summary: Mapping[str, Any], model: ClutchModel) -> dict[str, FloatArray]:
    """Posterior medians (1,) of the model's parameters, from posterior/summary.json."""
    found = {}
    for stage in summary.values():
        for name, entry in stage["parameters"].items():
            if name in model.parameters:
                found[name] = np.array([entry["median"]])
    return found


def multiplier_table(
    model: ClutchModel, conditions: RunConditions, parameters: Mapping[str, FloatArray]
) -> pd.DataFrame:
    """Median release per voltage with the calibrated force multiplier and with it held at 1 (Supplement S8)."""
    neutral = {name: value for name, value in parameters.items() if not name.startswith("force_multiplier")}
    neutral |= {"force_multiplier_level": np.ones(1), "force_multiplier_slope": np.zeros(1)}
    neutral = {name: value for name, value in neutral.items() if name in model.parameters}
    table = pd.DataFrame({"voltage_v": conditions.voltage})
    for label, used in (("with_multiplier", parameters), ("without_multiplier", neutral)):
        table[f"release_ms_{label}"] = (
            1e3 * model.predict(conditions, used, ["release_time_90_s"]).values["release_time_90_s"][0]
        )
    table = table.groupby("voltage_v").median().reset_index()
    table["change_percent"] = 100 * (table.iloc[:, 1] / table.iloc[:, 2] - 1)
    return table
