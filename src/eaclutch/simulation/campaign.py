"""A whole simulated campaign, in the layout of the contract: logs, side benches and campaign.yaml."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, InputError, RunConditions, RunSettings
from eaclutch.rig.logs import log_name, write_log
from eaclutch.rig.preload import substrate_of, weights_of
from eaclutch.rig.table import session_of
from eaclutch.simulation.bench_file import write_bench
from eaclutch.simulation.drive_signal import half_wave
from eaclutch.simulation.faults import damage
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.plan import Plan, PlannedRun, RecordTiming
from eaclutch.simulation.run import record_run
from eaclutch.simulation.side_benches import (
    capacitance_readings,
    spectra,
    write_capacitance,
    write_load_cell,
    write_permittivity,
)


@dataclass(frozen=True)
class SimulatedCampaign:
    """What was simulated: the runs' true conditions, the true parameters, the faults put into each run."""

    conditions: RunConditions
    parameters: Mapping[str, float]
    faults: Mapping[str, Sequence[str]]


def settings_of(run: PlannedRun, timing: RecordTiming, bench: Bench) -> RunSettings:
    """The settings that name a planned run's log. The preload is not known to the rig (-1 g)."""
    settings = RunSettings(
        "",
        run.stamp,
        timing.travel,
        bench.stage_speed,
        None,
        run.voltage,
        run.frequency,
        run.width,
        run.substrate,
    )
    return dataclasses.replace(settings, run=log_name(settings))


def values_of(model: ClutchModel, parameters: Mapping[str, float]) -> dict[str, float]:
    """Every parameter of the model by name, at its default where ``parameters`` has none. Raises InputError for a name
    that the model lacks."""
    unknown = sorted(set(parameters) - set(model.parameters))
    if unknown:
        raise InputError(
            f"parameters.{unknown[0]}",
            "is not a parameter of this model",
            "see eaclutch effects for the names",
        )
    return {name: float(parameters.get(name, p.default)) for name, p in model.parameters.items()}


def conditions_of(
    plan: Plan, bench: Bench, parameters: Mapping[str, float], preload_factors: np.ndarray | None = None
) -> RunConditions:
    """True conditions of the plan's runs, in its order; the switch-off force is left to the model.

    The friction before follows from the planned preload [N] and the kinetic coefficients in ``parameters``;
    ``preload_factors`` (runs,) scale the preloads.
    """
    factors = np.ones(len(plan.runs)) if preload_factors is None else preload_factors
    settings = [settings_of(run, plan.timing, bench) for run in plan.runs]
    sessions = tuple(session_of(run.stamp, bench) for run in plan.runs)
    base, film = parameters["base_kinetic"], parameters["film_kinetic"]
    friction, order, seen = [], [], dict.fromkeys(sessions, 0)
    for run, setting, session, factor in zip(plan.runs, settings, sessions, factors, strict=True):
        substrate_weight, film_weight = weights_of(setting, bench)
        friction.append((base + film) * run.preload * factor + base * substrate_weight + film * film_weight)
        order.append(seen[session])
        seen[session] += 1
    thickness = [substrate_of(setting, bench)[1] for setting in settings]
    dwell = np.array([half_wave(run.frequency) for run in plan.runs])
    return RunConditions(
        run=tuple(setting.run for setting in settings),
        session=sessions,
        condition=tuple(
            f"{run.substrate}_w{run.width * 1e3:g}_{run.voltage:g}V_{run.frequency:g}Hz_p{run.preload:g}N"
            for run in plan.runs
        ),
        substrate=tuple(run.substrate for run in plan.runs),
        voltage=np.array([run.voltage for run in plan.runs]),
        frequency=np.array([run.frequency for run in plan.runs]),
        width=np.array([run.width for run in plan.runs]),
        thickness=np.array(thickness),
        friction_before=np.array(friction),
        switch_off_force=np.full(len(plan.runs), np.nan),
        drive_duration=plan.timing.travel / bench.stage_speed + dwell,
        dwell=dwell,
        run_order=np.array(order, dtype=float),
    )


def simulate_campaign(
    folder: str | Path,
    plan: Plan,
    bench: Bench,
    effects: Sequence[str],
    parameters: Mapping[str, float],
    noise: BenchNoise,
    rng: np.random.Generator,
) -> SimulatedCampaign:
    """Write a campaign as the rig with ``effects`` switched on would have recorded it.

    folder: where (made; must not hold logs yet). parameters: values by name that depart from the model's
    defaults; effects' are called ``<effect>.<parameter>``. The same generator state gives the same bytes.
    Raises InputError for an unknown parameter, two runs of one name, or a folder that is in use.
    """
    folder = Path(folder)
    if (folder / "tensile").is_dir() and any((folder / "tensile").iterdir()):
        raise InputError(folder / "tensile", "holds recordings already", "name an empty folder")
    model = ClutchModel(bench, tuple(effects))
    values = values_of(model, parameters)
    streams = iter(rng.spawn(len(plan.runs) + 5))
    general = next(streams)
    preloads = np.exp(noise.preload_scatter_run * general.standard_normal(len(plan.runs)))
    conditions = conditions_of(plan, bench, values, preloads)
    if len(set(conditions.run)) < len(conditions):
        raise InputError("plan", "two runs have the same name", "give every run a stamp of its own")
    names = sorted(set(conditions.session))
    zeros = dict(
        zip(names, noise.zero_common + noise.zero_session * general.standard_normal(len(names)), strict=True)
    )
    faults: dict[str, Sequence[str]] = {}
    for index, planned in enumerate(plan.runs):
        own = next(streams)
        settings = settings_of(planned, plan.timing, bench)
        zero = zeros[conditions.session[index]] + noise.zero_run * own.standard_normal()
        recording = record_run(model, conditions, index, values, settings, plan.timing, zero, noise, own)
        recording, faults[settings.run] = damage(recording, plan.faults, own)
        write_log(recording, folder / "tensile" / f"{settings.run}{plan.extension}")
    write_capacitance(folder, capacitance_readings(model, values, plan.side, next(streams)))
    write_permittivity(folder, spectra(model, values, plan.side, next(streams)))
    first = min(run.stamp for run in plan.runs)
    write_load_cell(folder, values, plan.side, first, noise, next(streams))
    write_bench(folder, bench)
    return SimulatedCampaign(conditions, values, faults)
