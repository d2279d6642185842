"""A simulated campaign without its logs: the table of observables, as the extractor would have filled it.

Thousands of times faster than recording and extracting. What the bench does to a run is put on the observables
themselves: scatter of friction from run to run and slip to slip, the phase of the stick-slip at switch-off, the
unknown instant of the edges, and the extractor's own uncertainty (medians over simulated logs).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import PART, Prediction, Status
from eaclutch.records import Bench, BurstFeatures, CapacitanceReadings, FloatArray, RunConditions, Spectrum
from eaclutch.rig.preload import preload_of
from eaclutch.rig.table import empty_row, runs_table
from eaclutch.simulation.campaign import conditions_of, settings_of, values_of
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.plan import Plan, SideBenches
from eaclutch.simulation.run import scatter_factors
from eaclutch.simulation.side_benches import capacitance_readings, spectra

# Standard uncertainty that the extractor states, by observable (medians over simulated logs of this bench).
MEASUREMENT_SD: Mapping[str, float] = {
    "friction_before_n": 0.002, "engagement_time_s": 4e-4, "ramp_rate_n_s": 0.4, "ramp_rate_early_n_s": 1.4,
    "ramp_rate_late_n_s": 0.08, "shear_capacity_n": 0.008, "switch_off_force_n": 0.004, "slip_fraction": 0.02,
    "release_time_10_s": 8e-6, "release_time_50_s": 6e-6, "release_time_90_s": 8e-6, "final_force_n": 0.002,
}  # fmt: skip
EDGE_SD = 78.125e-6 / np.sqrt(12.0)  # s; shared by all times that count from one edge
TIMES = ("release_time_10_s", "release_time_50_s", "release_time_90_s")


@dataclasses.dataclass(frozen=True)
class SimulatedTable:
    """What a diagnosis starts from: the runs' table (columns of runs.csv) and the other benches' readings.

    truth: the noiseless observables (runs,) by name.
    """

    runs: pd.DataFrame
    readings: CapacitanceReadings
    spectra: tuple[Spectrum, ...]
    bursts: BurstFeatures
    truth: Mapping[str, FloatArray]


def simulate_table(
    plan: Plan,
    bench: Bench,
    effects: Sequence[str],
    parameters: Mapping[str, float],
    noise: BenchNoise,
    rng: np.random.Generator,
    **options: Any,
) -> SimulatedTable:
    """The campaign that ``simulate_campaign`` would write, as observables. Same arguments, no folder; ``options``:
    further keywords of ClutchModel."""
    model = ClutchModel(bench, tuple(effects), **options)
    values = values_of(model, parameters)
    preloads = np.exp(noise.preload_scatter_run * rng.standard_normal(len(plan.runs)))
    conditions = conditions_of(plan, bench, values, preloads)
    found, stated, truth = observe(model, conditions, values, noise, rng)
    # as many samples as a log holds of a drive that its sampling does not wait for
    edges = EDGE_SD * np.sqrt(12.0) * rng.spawn(1)[0].uniform(-0.5, 0.5, len(conditions))
    rows: list[dict[str, Any]] = []
    for index, run in enumerate(conditions.run):
        row = empty_row(run)
        duration = conditions.drive_duration[index] + edges[index]
        row |= {"drive_duration_s": duration, "dwell_s": conditions.dwell[index]}
        for name in found:
            row[name], row[f"{name}_sd"] = float(found[name][index]), float(stated[name][index])
        settings = settings_of(plan.runs[index], plan.timing, bench)
        row["preload_n"] = preload_of(row["friction_before_n"], settings, bench)
        row["usable"] = bool(np.isfinite([row["shear_capacity_n"], row["release_time_90_s"]]).any())
        row["flags"] = row["reasons"] = ""
        rows.append(row)
    return SimulatedTable(
        runs=runs_table(rows, bench),
        readings=capacitance_readings(model, values, plan.side, rng),
        spectra=spectra(model, values, plan.side, rng),
        bursts=_bursts(values, plan.side, rng),
        truth=truth,
    )


def observe(
    model: ClutchModel,
    conditions: RunConditions,
    parameters: Mapping[str, float],
    noise: BenchNoise,
    rng: np.random.Generator,
) -> tuple[dict[str, FloatArray], dict[str, FloatArray], dict[str, FloatArray]]:
    """(observed, stated sd, noiseless) observables, each (runs,); not-a-number where a run shows none.

    The noiseless ones already hold the run's own scatter and phase: that is what happened, not how it was read.
    """
    runs = len(conditions)
    static, kinetic = scatter_factors(noise, rng, runs)
    own: dict[str, Any] = dict(parameters)
    for name, factor in (("static", static), ("kinetic", kinetic)):
        for surface in ("film", "base"):
            own[f"{surface}_{name}"] = (parameters[f"{surface}_{name}"] * factor)[None]
    own["slip_phase"] = rng.uniform(0.0, 1.0, (1, runs))
    predicted = model.predict(conditions, own, on_invalid="status")
    truth = {name: _where_ok(predicted, name) for name in MEASUREMENT_SD}
    held = np.isnan(truth["final_force_n"])  # nothing let go: the force stays where it was
    truth["final_force_n"] = np.where(held, truth["switch_off_force_n"], truth["final_force_n"])
    slips = _slips(model, conditions, truth)
    largest = np.array([np.exp(noise.capacity_scatter_slip * rng.standard_normal(n)).max() for n in slips])
    before = conditions.friction_before
    truth["shear_capacity_n"] = (truth["shear_capacity_n"] + before) * largest - before
    observed, stated = {}, {}
    edge = EDGE_SD * np.sqrt(12.0) * rng.uniform(-0.5, 0.5, runs)
    for name, sd in MEASUREMENT_SD.items():
        shared = edge if name in TIMES else 0.0
        observed[name] = truth[name] + sd * rng.standard_normal(runs) + shared
        stated[name] = np.full(runs, np.hypot(sd, EDGE_SD) if name in TIMES else sd)
    _derive(observed, stated)
    stated = {name: np.where(np.isnan(observed[name]), np.nan, sd) for name, sd in stated.items()}
    return observed, stated, truth


def _where_ok(predicted: Prediction, name: str) -> FloatArray:
    fine = predicted.status[PART[name]][0] == Status.ok
    if PART[name] == "capacity":  # a run that never slips still has a largest force
        fine |= predicted.status["capacity"][0] == Status.never_slips
    return np.where(fine, predicted.values[name][0], np.nan)


def _slips(model: ClutchModel, conditions: RunConditions, truth: Mapping[str, FloatArray]) -> np.ndarray:
    """How often each run slips while the stage pushes it, at least once (runs,)."""
    rate = model.parameters["stiffness"].default * model.bench.stage_speed
    top = truth["shear_capacity_n"] + conditions.friction_before
    pushed = conditions.drive_duration - conditions.dwell - truth["shear_capacity_n"] / rate
    with np.errstate(invalid="ignore"):
        count = pushed * rate / np.maximum(truth["slip_fraction"] * top, 1e-3)
    return np.clip(np.nan_to_num(count, nan=1.0), 1, 1000).astype(int)


def _derive(observed: dict[str, FloatArray], stated: dict[str, FloatArray]) -> None:
    """Observables that the extractor works out of others."""
    final, held = observed["final_force_n"], observed["switch_off_force_n"]
    before = observed["friction_before_n"]
    span = observed["shear_capacity_n"] + before - final
    observed["start_ratio"] = (held - final) / span
    stated["start_ratio"] = (
        np.hypot(stated["switch_off_force_n"], observed["start_ratio"] * stated["shear_capacity_n"]) / span
    )
    observed["baseline_shift_n"] = final - before
    stated["baseline_shift_n"] = np.hypot(stated["final_force_n"], stated["friction_before_n"])


def _bursts(parameters: Mapping[str, float], side: SideBenches, rng: np.random.Generator) -> BurstFeatures:
    """Ten bursts a log, with the scatter that the extractor finds in simulated ones."""
    count = 10 * side.load_cell_logs
    k, m, b = (parameters[name] for name in ("stiffness", "mass", "damping"))
    ratio = b / (2 * np.sqrt(k * m))
    frequency = np.sqrt(k / m * (1 - ratio**2)) / (2 * np.pi)
    sds = np.full(count, 2.0), np.full(count, 0.003)
    return BurstFeatures(
        frequency + sds[0] * rng.standard_normal(count),
        sds[0],
        ratio + sds[1] * rng.standard_normal(count),
        sds[1],
    )
