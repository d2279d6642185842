"""predict/runs.csv and coverage.json: every run predicted with and without itself in the fit."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.inference.coverage import coverage_document, ranks
from eaclutch.inference.draws import load_draws, with_prior_draws
from eaclutch.inference.left_out import folds, refit_draws, unseen_voltages, without
from eaclutch.inference.posterior import StageInputs, force_response
from eaclutch.inference.prediction import Measured, Predicted, predict_runs, replicate
from eaclutch.inference.repeatability import Scatter
from eaclutch.inference.response import Response
from eaclutch.physics.model import ClutchModel
from eaclutch.records import FloatArray

COLUMNS = ("run", "observable", "q05", "median", "q95", "measured", "measured_sd", "status", "held_out")
TOGETHER = 500  # runs that are predicted at once
NINETY = 8  # index of the 90 % level in the calibration curves
logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Campaign:
    """What all predictions share."""

    model: ClutchModel
    inputs: StageInputs
    measured: Measured
    scatters: Mapping[str, Scatter]
    response: Response | None
    draws: int

    def predicted(
        self, rows: np.ndarray, joint: Mapping[str, FloatArray], rng: np.random.Generator
    ) -> Predicted:
        """Runs ``rows`` at joint draws, some hundred at once: a model's own arrays are many times what is kept."""
        found, errors = [], self.measured.errors()
        for some in np.array_split(rows, max(1, -(-len(rows) // TOGETHER))):
            part = self.measured.select(some)
            prediction = predict_runs(self.model, part.conditions, joint, tuple(part.values))
            own = {name: sd[some] for name, sd in errors.items()}
            found.append(replicate(prediction, own, self.scatters, rng))
        return Predicted(
            {n: np.concatenate([f.replicated[n] for f in found], axis=1) for n in found[0].replicated},
            {n: np.concatenate([f.status[n] for f in found]) for n in found[0].status},
        )

    def refit(self, rows: np.ndarray, rng: np.random.Generator) -> dict[str, FloatArray]:
        """Force draws without the runs ``rows``; its prior where no run is left."""
        data = self.inputs.capacity
        if data is None or self.response is None:
            return {}
        gone = {self.measured.conditions.run[i] for i in rows}
        keep = np.array([run not in gone for run in data.conditions.run])
        form, known = self.inputs.multiplier_form, dict(self.inputs.parameters)
        return refit_draws(without(data, self.response, keep, form, known), self.draws, rng)

    def split(
        self, labels: tuple[str, ...], parts: int, joint: Mapping[str, FloatArray], rng: np.random.Generator
    ) -> Predicted | None:
        """Each run predicted from a fit without all runs of its label; None where there is one label only."""
        if len(set(labels)) < 2:
            return None
        names = np.array(labels)
        replicated = {name: np.full((self.draws, len(labels)), np.nan) for name in self.measured.values}
        status = {name: np.full(len(labels), "", dtype=object) for name in self.measured.values}
        for group in folds(labels, parts, rng):
            rows = np.flatnonzero(np.isin(names, sorted(group)))
            refit = self.refit(rows, rng)
            if refit and self.inputs.multiplier_form == "per_voltage":
                refit |= unseen_voltages(joint, refit, self.draws, rng)
            part = self.predicted(rows, {**joint, **refit}, rng)
            for name in replicated:
                replicated[name][:, rows] = part.replicated[name]
                status[name][rows] = part.status[name]
        return Predicted(replicated, status)


def predict_campaign(
    model: ClutchModel, inputs: StageInputs, measured: Measured, *, seed: int, draws: int, parts: int
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Rows of predict/runs.csv and the calibration curves of three splits.

    ``inputs.earlier``: all stages' files; ``parts``: into how many the conditions (sessions) are split.
    Every (run, observable) has two rows: from the posterior of all runs (held_out false) and from one that has not
    seen the run's condition (held_out true). Left out by session stands in the curves only.
    """
    if not len(measured.conditions):
        return pd.DataFrame(columns=list(COLUMNS)), {}
    rng = np.random.default_rng([seed, 11])
    joint = with_prior_draws(load_draws(inputs.earlier, draws), inputs.parameters, draws, rng)
    response = None
    if inputs.capacity is not None and len(inputs.capacity.capacity):
        stages = [path for path in inputs.earlier if path.stem != "force"]
        response = force_response(replace(inputs, earlier=stages), rng)
    campaign = _Campaign(model, inputs, measured, measured.scatters(), response, draws)
    found = {
        "in_sample": campaign.predicted(np.arange(len(measured.conditions)), joint, rng),
        "left_out_condition": campaign.split(measured.conditions.condition, parts, joint, rng),
        "left_out_session": campaign.split(measured.conditions.session, parts, joint, rng),
    }
    curves = coverage_document(
        {
            name: {o: ranks(part.replicated[o], measured.values[o]) for o in measured.values}
            for name, part in found.items()
            if part is not None
        }
    )
    for name, part in curves.items():
        if part["all"] is not None:
            logger.info(
                "predict: %s, 90 %% intervals cover %.1f %%", name, 100 * part["all"]["covered"][NINETY]
            )
    tables = [_rows(measured, part, name != "in_sample") for name, part in found.items()
              if part is not None and name != "left_out_session"]  # fmt: skip
    table = pd.concat(tables, ignore_index=True)
    return table.sort_values(["run", "observable", "held_out"], ignore_index=True), curves


def _rows(measured: Measured, predicted: Predicted, held_out: bool) -> pd.DataFrame:
    """A row a (run, observable) that was measured or can be predicted; quantiles only where most draws have one."""
    tables = []
    for name, values in predicted.replicated.items():
        finite = np.isfinite(values)
        enough = finite.mean(axis=0) > 0.5
        filled = np.where(enough, values, 0.0)
        quantiles = np.where(enough, np.nanquantile(filled, [0.05, 0.5, 0.95], axis=0), np.nan)
        tables.append(
            pd.DataFrame(
                {
                    "run": measured.conditions.run,
                    "observable": name,
                    "q05": quantiles[0],
                    "median": quantiles[1],
                    "q95": quantiles[2],
                    "measured": measured.values[name],
                    "measured_sd": measured.sds[name],
                    "status": predicted.status[name],
                    "held_out": held_out,
                }
            )
        )
    return pd.concat(tables, ignore_index=True)[list(COLUMNS)]
