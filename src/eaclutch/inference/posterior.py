"""One stage of the posterior: problem, sampling, files."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from eaclutch.inference import draws as joint_draws
from eaclutch.inference import storage
from eaclutch.inference.convergence import Thresholds
from eaclutch.inference.draws import with_prior_draws
from eaclutch.inference.importance import width_check
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem
from eaclutch.inference.response import Response
from eaclutch.inference.sampling import Sampled, SamplerSettings, sample
from eaclutch.inference.sensitivity import sensitivity, warnings_of
from eaclutch.inference.stages.contact import ContactSettings, FilmOffset, contact_problem
from eaclutch.inference.stages.dielectric import dielectric_problem
from eaclutch.inference.stages.force import CapacityData, force_problem
from eaclutch.inference.stages.load_cell import load_cell_problem
from eaclutch.physics.effect import Parameter
from eaclutch.physics.laws import permittivity
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import Status
from eaclutch.records import Bench, BurstFeatures, CapacitanceReadings, FloatArray, RunConditions, Spectrum

RESPONSE_DRAWS = 200  # joint draws for which the capacity is tabulated
logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class StageInputs:
    """What a stage may need; what it does not need may stay None. ``earlier``: files of stages before it."""

    bench: Bench
    parameters: Mapping[str, Parameter]
    readings: CapacitanceReadings | None = None
    spectra: Sequence[Spectrum] = ()
    spectra_weights: Mapping[str, float] | None = None
    bursts: BurstFeatures | None = None
    capacity: CapacityData | None = None
    contact: ContactSettings = field(default_factory=ContactSettings)
    multiplier_form: str = "linear"
    model: Mapping[str, Any] | None = (
        None  # arguments of ClutchModel beside the bench and the multiplier's form
    )
    earlier: Sequence[Path] = ()


def sampler_settings(config: Mapping[str, Any]) -> SamplerSettings:
    """From the config's ``posterior`` section."""
    limits = Thresholds(config["r_hat_max"], config["ess_min"], config["autocorrelation_times_min"])
    return SamplerSettings(
        config["ensembles"], config["walkers"], config["check_every_steps"], config["max_steps"], limits,
        config["stored_draws"],
    )  # fmt: skip


def stage_problem(stage: str, inputs: StageInputs, rng: np.random.Generator) -> Problem:
    """The problem of a stage; ``rng`` draws priors of what earlier stages have not calibrated."""
    known = inputs.parameters
    if stage == "dielectric":
        return dielectric_problem(inputs.spectra, known, weights=inputs.spectra_weights)
    if stage == "load_cell":
        return load_cell_problem(inputs.bursts, known)
    if stage == "contact":
        return contact_problem(
            inputs.readings, inputs.bench, known, _film_offset(inputs, rng), inputs.contact
        )
    return _force(inputs, rng)


def run_stage(
    problem: Problem, settings: SamplerSettings, seed: int, checkpoint: Path | None = None
) -> tuple[storage.arviz.InferenceData, Sampled | None]:
    """Sample a stage (or rest on its prior) and collect its groups."""
    sampled = (
        sample(problem, settings, seed, checkpoint=checkpoint, progress=logger.info)
        if problem.has_data
        else None
    )
    if sampled is not None:
        logger.info(
            "%s: %s after %d steps; %d likelihood evaluations in %.1f s, %.0f a second",
            problem.stage, "converged" if sampled.converged else f"NOT converged ({'; '.join(sampled.failures)})",
            sampled.total_steps, sampled.evaluations, sampled.seconds, sampled.evaluations_per_second,
        )  # fmt: skip
    data = storage.inference_data(problem, settings, seed, sampled)
    if sampled is not None:
        rows = sensitivity(problem.priors, sampled.flat, sampled.log_density.reshape(-1))
        data.attrs["sensitivity"] = json.dumps(rows, sort_keys=True)
        found = warnings_of(rows)
        for line in found:
            logger.warning("%s: %s", problem.stage, line)
        if problem.wider is not None:
            found.append(width_check(problem.wider, np.random.default_rng([seed, 2])))
            logger.info("%s: %s", problem.stage, found[-1])
        data.attrs["findings"] = json.dumps(found)
        data.attrs["notes"] = "; ".join([*problem.notes, *found])  # what the report shows
    return data, sampled


def gate(
    problem: Problem, settings: SamplerSettings, sampled: Sampled | None, data: storage.arviz.InferenceData
) -> dict[str, Any]:
    """The gate's document: whether the stage may be relied on, what was measured against what, and what was found."""
    document: dict[str, Any] = {
        "stage": problem.stage, "source": "data" if sampled is not None else "prior", "converged": None,
        "failures": [], "notes": [*problem.notes, *json.loads(data.attrs.get("findings", "[]"))],
        "thresholds": {"r_hat_max": settings.thresholds.r_hat, "ess_min": settings.thresholds.ess,
                       "autocorrelation_times_min": settings.thresholds.lengths},
    }  # fmt: skip
    if sampled is not None:
        found = sampled.diagnostics
        document |= {
            "converged": sampled.converged, "failures": list(sampled.failures), "steps": sampled.total_steps,
            "autocorrelation_times": found.lengths, "r_hat_max": float(np.max(found.r_hat)),
            "ess_min": float(min(found.ess_bulk.min(), found.ess_tail.min())),
        }  # fmt: skip
    return document


def _film_offset(inputs: StageInputs, rng: np.random.Generator, draws: int = 4000) -> FilmOffset:
    """T_d / kappa at the meter's frequency, from the dielectric draws and the prior of the thickness."""
    joint = joint_draws.load_draws(inputs.earlier, draws) if inputs.earlier else {}
    complete = with_prior_draws(joint, inputs.parameters, draws, rng)
    kappa = permittivity(
        inputs.bench.fixture.meter_frequency, complete["kappa_static"], complete["kappa_infinity"],
        complete["relaxation_time"], complete["cole_cole_exponent"],
    )  # fmt: skip
    thickness = Priors.of([inputs.parameters["film_thickness"]]).sample(rng, draws)[:, 0]
    return FilmOffset.of(thickness, kappa)


def _force(inputs: StageInputs, rng: np.random.Generator) -> Problem:
    form = inputs.multiplier_form
    if inputs.capacity is None or not len(inputs.capacity.capacity):
        return force_problem(None, None, form, inputs.parameters)  # type: ignore[arg-type]
    return force_problem(inputs.capacity, force_response(inputs, rng), form, inputs.parameters)  # type: ignore[arg-type]


def force_response(inputs: StageInputs, rng: np.random.Generator) -> Response:
    """The capacities of ``inputs`` tabulated over the multiplier for joint draws of the earlier stages."""
    assert inputs.capacity is not None
    model = ClutchModel(inputs.bench, **dict(inputs.model or {}), force_multiplier_form="constant")
    joint = joint_draws.load_draws(inputs.earlier, RESPONSE_DRAWS) if inputs.earlier else {}
    known = {name: inputs.parameters.get(name, p) for name, p in model.parameters.items()}
    nuisances = with_prior_draws(joint, known, RESPONSE_DRAWS, rng)
    nuisances = {
        name: v for name, v in nuisances.items() if name in known and not name.startswith("force_multiplier")
    }
    units = {name: known[name].unit for name in nuisances}
    spans = {name: known[name].bounds for name in nuisances if known[name].prior.distribution == "uniform"}
    return Response.tabulate(capacity_function(model, inputs.capacity.conditions), nuisances, units, spans)


def capacity_function(model: ClutchModel, conditions: RunConditions) -> Any:
    """(nuisances, multiplier) -> shear capacity (draws, runs) [N]; NaN where the model pulls in. A drive that ends
    before the capacity is reached counts the force that was reached."""

    def capacity(nuisances: Mapping[str, FloatArray], multiplier: float) -> FloatArray:
        parameters = dict(nuisances) | {"force_multiplier_level": np.float64(multiplier)}
        found = model.predict(conditions, parameters, ("shear_capacity_n",), on_invalid="status")
        status = found.status_of("shear_capacity_n")
        fine = (status == Status.ok) | (status == Status.never_slips)
        value = found.values["shear_capacity_n"]
        return np.where(fine & (value > 0), value, np.nan)

    return capacity


def with_code(problem: Problem, code: str) -> Problem:
    """The problem with the hash of the code it rests on in its fingerprint."""
    return replace(problem, fingerprint={**problem.fingerprint, "code": code})
