"""The stages as problems whose data can be exchanged, for calibration studies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from eaclutch.inference.calibration import Replicable
from eaclutch.inference.posterior import StageInputs, force_response, stage_problem
from eaclutch.inference.stages.contact import select
from eaclutch.inference.stages.force import force_problem
from eaclutch.records import FloatArray, InputError


def replicable(stage: str, inputs: StageInputs, rng: np.random.Generator) -> Replicable:
    """The stage of a campaign with its data's layout (forces, frequencies, conditions), ready for made-up data.

    Raises InputError where the campaign has no data for the stage: there is no layout then.
    """
    if stage == "force":
        return _force(inputs, rng)
    state = rng.bit_generator.state

    def build(changed: StageInputs):  # type: ignore[no-untyped-def]
        again = np.random.default_rng()
        again.bit_generator.state = state  # every data set meets the same nuisance draws
        return stage_problem(stage, changed, again)

    problem = build(inputs)
    if not problem.has_data:
        raise InputError(
            f"stage {stage}", "has no data whose layout could be used", "choose another campaign"
        )

    def rebuild(observed: FloatArray):  # type: ignore[no-untyped-def]
        return build(_with_data(stage, inputs, observed))

    return Replicable(problem, rebuild)


def _with_data(stage: str, inputs: StageInputs, observed: FloatArray) -> StageInputs:
    """``inputs`` with the stage's data replaced by ``observed`` (in the problem's own unit and order)."""
    if stage == "load_cell":
        assert inputs.bursts is not None
        frequency, ratio = np.split(observed, 2)
        return replace(inputs, bursts=replace(inputs.bursts, frequency=frequency, damping_ratio=ratio))
    if stage == "dielectric":
        weights = inputs.spectra_weights or {}
        spectra, place = [], 0
        for spectrum in inputs.spectra:
            if weights.get(spectrum.source, 1.0) > 0 and len(spectrum.frequency):
                part = observed[place : place + len(spectrum.frequency)]
                spectra.append(replace(spectrum, permittivity=part))
                place += len(part)
        return replace(inputs, spectra=tuple(spectra))
    assert inputs.readings is not None
    keep, _ = select(inputs.readings, inputs.bench, inputs.contact)
    capacitance = inputs.readings.capacitance.copy()
    capacitance[keep] = np.exp(observed)
    return replace(inputs, readings=replace(inputs.readings, capacitance=capacitance))


def _force(inputs: StageInputs, rng: np.random.Generator) -> Replicable:
    """The force stage; its response is tabulated once and serves all data."""
    data = inputs.capacity
    if data is None or not len(data.capacity):
        raise InputError("stage force", "has no data whose layout could be used", "choose another campaign")
    response = force_response(inputs, rng)
    share = data.capacity_sd / data.capacity

    def rebuild(observed: FloatArray):  # type: ignore[no-untyped-def]
        capacity = np.exp(observed)
        made = replace(data, capacity=capacity, capacity_sd=share * capacity)
        return force_problem(made, response, inputs.multiplier_form, inputs.parameters)  # type: ignore[arg-type]

    return Replicable(rebuild(np.log(data.capacity)), rebuild)
