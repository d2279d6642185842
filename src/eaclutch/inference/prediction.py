"""Posterior predictions of runs: the model at joint draws, plus how runs repeat and how they are measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from eaclutch.inference.cells import Cells
from eaclutch.inference.draws import PER_RUN
from eaclutch.inference.repeatability import Scatter, scatter
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import Prediction, Status
from eaclutch.records import FloatArray, RunConditions

# Inputs of the prediction rather than predictions: the model is told them run by run.
GIVEN = ("friction_before_n",)
# Predicted without the measured force at switch-off: where a run stands in its stick-slip cycle is drawn evenly, and
# that is how its repeats differ, so no further scatter between repeats is added.
FREE = ("switch_off_force_n", "start_ratio")


@dataclass(frozen=True)
class Measured:
    """Runs and what was measured: values and sds {observable: (runs,)}, NaN where unusable; preload (runs,) [N]."""

    conditions: RunConditions
    values: Mapping[str, FloatArray]
    sds: Mapping[str, FloatArray]
    preload: FloatArray

    def select(self, rows: np.ndarray) -> Measured:
        """Some of the runs."""
        return Measured(
            self.conditions.select(rows), {n: v[rows] for n, v in self.values.items()},
            {n: v[rows] for n, v in self.sds.items()}, self.preload[rows],
        )  # fmt: skip

    def errors(self) -> dict[str, FloatArray]:
        """Measurement sds {observable: (runs,)}, the median where a run has none."""
        found = {}
        for name, sd in self.sds.items():
            known = np.isfinite(sd)
            found[name] = np.where(known, sd, np.median(sd[known]) if known.any() else 0.0)
        return found

    def scatters(self) -> dict[str, Scatter]:
        cells = Cells.of(self.conditions.session, self.conditions.condition)
        return {
            name: scatter(values, self.sds[name], self.preload, cells) for name, values in self.values.items()
        }


@dataclass(frozen=True)
class Predicted:
    """replicated {observable: (draws, runs)}: what another measurement of the same run would read, NaN where the
    model has no number; status {observable: (runs,)}: the most frequent over the draws, by name."""

    replicated: Mapping[str, FloatArray]
    status: Mapping[str, np.ndarray]


def predict_runs(
    model: ClutchModel, conditions: RunConditions, joint: Mapping[str, FloatArray], observables: Sequence[str]
) -> Prediction:
    """The model at joint draws {name: (draws,)}; multipliers by form become the model's own parameters.

    Runs start their release at the measured force, but for ``FREE`` observables, which the model predicts alone.
    """
    draws = len(next(iter(joint.values())))
    parameters: dict[str, FloatArray] = {
        n: v for n, v in joint.items() if n in model.parameters and n not in PER_RUN
    }
    law = [name for name in joint if name.startswith("force_multiplier_") and name.endswith("v")]
    if law:  # a multiplier a voltage: a level per run
        levels = np.array([float(name.removeprefix("force_multiplier_").removesuffix("v")) for name in law])
        nearest = np.argmin(np.abs(conditions.voltage[:, None] - levels[None, :]), axis=1)
        parameters["force_multiplier_level"] = np.stack([joint[law[i]] for i in nearest], axis=1)
    if (
        "slip_phase" in model.parameters
    ):  # where in its cycle a run stands is spread evenly over draws and runs
        step = (np.arange(draws)[:, None] + 0.5) / draws + np.arange(len(conditions))[None, :] * 0.61803398875
        parameters["slip_phase"] = step % 1.0
    told = [name for name in observables if name not in FREE]
    found = model.predict(conditions, parameters, told, on_invalid="status")
    free = [name for name in observables if name in FREE]
    if not free:
        return found
    alone = replace(conditions, switch_off_force=np.full(len(conditions), np.nan))
    own = model.predict(alone, parameters, free, on_invalid="status")
    # where the model alone has no number the run has none either; statuses are those of the told runs
    return replace(found, values={**found.values, **own.values})


def replicate(
    prediction: Prediction,
    errors: Mapping[str, FloatArray],
    scatters: Mapping[str, Scatter],
    rng: np.random.Generator,
) -> Predicted:
    """Predictions with the scatter between runs and the measurement's own error, sds (runs,), added."""
    replicated, status = {}, {}
    for name, value in prediction.values.items():
        codes = prediction.status_of(name)
        noise: FloatArray = np.broadcast_to(errors[name], value.shape)
        if name not in FREE:
            noise = np.hypot(scatters[name].sd(np.nan_to_num(value)), noise)
        replicated[name] = value + noise * rng.standard_normal(value.shape)
        counts = np.stack([(codes == s).sum(axis=0) for s in Status])
        status[name] = np.array([Status(i).name for i in np.argmax(counts, axis=0)])
    return Predicted(replicated, status)
