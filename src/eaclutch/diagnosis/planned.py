"""A campaign that has only been planned: its design as a study of data that the base model itself made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from eaclutch.diagnosis.files import model_of
from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.diagnosis.study import Study
from eaclutch.records import Campaign, InputError
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.observables import simulate_table
from eaclutch.simulation.plan import Plan, PlannedRun

ASSUMED_PRELOAD = 0.12  # N, where a log's name does not say


def plan_of(campaign: Campaign) -> Plan:
    """The campaign's runs as planned: from the names of its logs alone, no log is opened."""
    runs = tuple(
        PlannedRun(
            stamp=log.settings.stamp,
            voltage=log.settings.voltage,
            frequency=log.settings.frequency,
            width=log.settings.width,
            preload=ASSUMED_PRELOAD if log.settings.preload is None else log.settings.preload,
            substrate=log.settings.substrate,
        )
        for log in campaign.logs
        if log.settings.voltage > 0
    )
    if not runs:
        raise InputError(campaign.folder, "no run with a voltage is planned", "add logs or a plan")
    return Plan(runs)


def planned_study(
    campaign: Campaign, settings: Mapping[str, Any], thresholds: Mapping[str, Any], seed: int
) -> Study:
    """A study of one data set that the model makes for the campaign's design."""
    effects, options = model_of(settings)
    rng = np.random.default_rng([seed, 31])
    table = simulate_table(plan_of(campaign), campaign.bench, effects, {}, BenchNoise(), rng, **options)
    inputs = DiagnosisInputs(
        campaign.bench, table.runs, table.readings, table.spectra, table.bursts, effects,
        tuple(settings.get("diagnosis", {}).get("candidates") or ()), options, settings.get("priors") or {},
    )  # fmt: skip
    return Study(inputs, thresholds, seed)
