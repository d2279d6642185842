"""The force multiplier from measured shear capacities, given joint draws of everything else.

ln capacity_r = ln model_r(lambda(V_r), phi) + session + condition + run scatter + measurement error.

phi, the parameters of the other stages and the friction coefficients, comes as draws: the model's response is
tabulated for every draw and run over a grid of lambda, and its spread over the draws is a few common factors
(`response`), z ~ N(0, I), that are marginalised with the levels. Runs of one (condition, session) share their levels,
so each such cell enters by its weighted mean and its scatter. The capacities inform phi as well: ``derived`` moves
each draw of phi with them.

Runs whose model pulls in (no equilibrium with voltage) have no capacity there; a measured run then counts the share
of draws that have one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from eaclutch.inference.cells import Cells, cell_likelihood
from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem, digest
from eaclutch.inference.response import Response
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.physics.parameters import MULTIPLIER_VOLTAGE
from eaclutch.records import FloatArray, RunConditions

Form = Literal["none", "constant", "linear", "per_voltage"]
LEVEL, SLOPE = "force_multiplier_level", "force_multiplier_slope"
MULTIPLIER = "force_multiplier_"
MOST_RUNS = 600  # whose capacities are fitted: matrices of 3 MB
TOGETHER = 10_000_000  # numbers in the covariances that are worked on at once
VOLTAGE_PRIOR = Prior("lognormal", 1.0, 0.2)  # of a voltage's own multiplier


@dataclass(frozen=True)
class MultiplierLaw:
    """lambda_ea of runs: parameters by form and the map (draws, params) -> (draws, runs)."""

    form: Form
    parameters: tuple[Parameter, ...]
    weights: FloatArray  # (params, runs)

    @classmethod
    def of(cls, form: Form, voltage: FloatArray, parameters: Mapping[str, Parameter]) -> MultiplierLaw:
        if form == "none":
            return cls(form, (), np.zeros((0, len(voltage))))
        level = parameters[LEVEL]
        if form == "constant":
            return cls(form, (level,), np.ones((1, len(voltage))))
        if form == "linear":
            weights = np.stack([np.ones_like(voltage), voltage - MULTIPLIER_VOLTAGE])
            return cls(form, (level, parameters[SLOPE]), weights)
        levels = np.unique(voltage)
        named = tuple(
            Parameter(f"{MULTIPLIER}{v:g}v", "1", level.bounds, level.default, VOLTAGE_PRIOR) for v in levels
        )
        return cls(form, named, (voltage[None, :] == levels[:, None]).astype(float))

    def __call__(self, theta: FloatArray) -> FloatArray:
        if self.form == "none":
            return np.ones((len(theta), self.weights.shape[1]))
        return theta[:, : len(self.parameters)] @ self.weights


@dataclass(frozen=True)
class CapacityData:
    """Measured shear capacity [N] and its standard uncertainty, (runs,), of usable runs with voltage; thinned_from:
    how many there were before ``thinned`` left some out (0: none)."""

    conditions: RunConditions
    capacity: FloatArray
    capacity_sd: FloatArray
    thinned_from: int = 0

    def thinned(self, most: int = MOST_RUNS) -> CapacityData:
        """At most ``most`` runs, the conditions in turn, each with as many sessions as there are before any repeats:
        memory stays bounded, and levels that runs share are not better known from more of them."""
        count = len(self.capacity)
        if count <= most:
            return self
        cells = Cells.of(self.conditions.session, self.conditions.condition)
        frame = pd.DataFrame({"condition": cells.condition, "cell": cells.cell})
        frame["repeat"] = frame.groupby("cell").cumcount()
        # sessions in an order that leaves no pattern, another one in each condition (golden ratio, plastic number)
        frame["shuffled"] = (0.6180339887 * cells.session + 0.7548776662 * cells.condition) % 1.0
        frame = frame.sort_values(["repeat", "shuffled"], kind="stable")
        frame["turn"] = frame.groupby("condition").cumcount()
        rows = np.sort(frame.sort_values(["turn", "condition"], kind="stable").index[:most].to_numpy())
        return CapacityData(self.conditions.select(rows), self.capacity[rows], self.capacity_sd[rows], count)


def force_problem(
    data: CapacityData | None, response: Response | None, form: Form, parameters: Mapping[str, Parameter]
) -> Problem:
    """The force stage. ``parameters`` holds the multiplier's level and slope with their priors."""
    if data is None or response is None or not len(data.capacity):
        # no voltage, no level of its own: one for all is what a prediction can use
        law = MultiplierLaw.of("constant" if form == "per_voltage" else form, np.zeros(0), parameters)
        return Problem("force", Priors.of(law.parameters), notes=("no usable shear capacity",))
    runs = data.conditions
    law = MultiplierLaw.of(form, runs.voltage, parameters)
    cells = Cells.of(runs.session, runs.condition)
    notes = [f"{len(data.capacity)} runs in {cells.count} cells of condition and session"]
    if data.thinned_from:
        notes.append(f"{len(data.capacity)} of {data.thinned_from} runs, evenly over conditions and sessions")
    if len(set(runs.session)) == 1:
        notes.append("one session only: the spread between sessions rests on its prior")
    if form == "linear" and len(np.unique(runs.voltage)) == 1:
        notes.append("one voltage only: the multiplier's slope rests on its prior")
    hyper = ("session_spread", "condition_spread", "run_spread")
    priors = Priors.of([*law.parameters, *(parameters.get(n, HYPERPARAMETERS[n]) for n in hyper)])
    observed = np.log(data.capacity)
    own = (data.capacity_sd / data.capacity) ** 2
    head = len(law.parameters)

    def parts(theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Residuals (draws, runs), factors (draws, factors, runs), variances (draws, runs), log share."""
        mean, factors, log_share = response.at(law(theta))
        variance = theta[:, head + 2, None] ** 2 + own
        return observed - mean, factors, variance, np.sum(log_share, axis=1)

    def log_likelihood(theta: FloatArray) -> FloatArray:
        residual, factors, variance, share = parts(theta)
        value = cell_likelihood(residual, factors, variance, theta[:, head], theta[:, head + 1], cells)
        return np.where(np.isfinite(share), value + share, -np.inf)

    def dense(theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Residuals (draws, runs), factors (draws, factors, runs) and covariances (draws, runs, runs)."""
        residual, factors, variance, _ = parts(theta)
        levels = theta[:, head, None, None] ** 2 * cells.same_session
        levels = levels + theta[:, head + 1, None, None] ** 2 * cells.same_condition
        total = np.einsum("dqr,dqs->drs", factors, factors) + levels
        rows = np.arange(len(observed))
        total[:, rows, rows] += variance
        return residual, factors, total

    def pieces(draws: int) -> list[np.ndarray]:
        """Draws whose dense covariances are worked out together."""
        at_once = int(np.clip(TOGETHER // len(observed) ** 2, 1, 50))
        return np.array_split(np.arange(draws), max(-(-draws // at_once), 1))

    def pointwise(theta: FloatArray) -> FloatArray:
        result = np.empty((len(theta), len(observed)))
        for piece in pieces(len(theta)):
            residual, _, total = dense(theta[piece])
            precision = np.linalg.inv(total)
            weight = np.einsum("drr->dr", precision)
            gap = np.einsum("drs,ds->dr", precision, residual) / weight
            result[piece] = 0.5 * np.log(weight / (2 * np.pi)) - 0.5 * weight * gap**2
        return result

    def moved_scores(theta: FloatArray, rng: np.random.Generator) -> tuple[np.ndarray, FloatArray]:
        """Nuisance draws (their numbers) and their scores as the capacities move them, jointly with theta.

        Matheron's rule: a draw of z plus the gain times what its own simulated data miss; exact where z is Gaussian.
        """
        which = rng.integers(0, response.draws, len(theta))
        moved = np.empty((len(theta), response.rank))
        for piece in pieces(len(theta)):
            residual, factors, total = dense(theta[piece])
            rest = total - np.einsum("dqr,dqs->drs", factors, factors)
            noise = np.einsum("drs,ds->dr", np.linalg.cholesky(rest), rng.standard_normal(residual.shape))
            z = response.z[which[piece]]
            innovation = residual - np.einsum("dq,dqr->dr", z, factors) - noise
            weight = np.linalg.solve(total, innovation[..., None])[..., 0]
            moved[piece] = z + np.einsum("dqr,dr->dq", factors, weight)
        return which, moved

    def predictive(theta: FloatArray, rng: np.random.Generator, posterior: bool = True) -> FloatArray:
        residual, factors, variance, _ = parts(theta)
        z = moved_scores(theta, rng)[1] if posterior else rng.standard_normal(factors.shape[:2])
        value = observed - residual + np.einsum("dq,dqr->dr", z, factors)
        value += np.sqrt(variance) * rng.standard_normal(variance.shape)
        sessions = rng.standard_normal((len(theta), cells.sessions)) * theta[:, head, None]
        conditions = rng.standard_normal((len(theta), cells.conditions)) * theta[:, head + 1, None]
        return value + sessions[:, cells.session] + conditions[:, cells.condition]

    def derived(theta: FloatArray, rng: np.random.Generator) -> dict[str, FloatArray]:
        """Nuisance draws moved by the capacities (joint with theta)."""
        return response.nuisances(*moved_scores(theta, rng))

    return Problem(
        "force", priors, log_likelihood, pointwise, predictive, observed,
        data_name="log_shear_capacity", data_unit="ln N",
        coords={"run": np.array(runs.run), "voltage": runs.voltage, "frequency": runs.frequency,
                "session": np.array(runs.session), "condition": np.array(runs.condition)},
        derived=derived, derived_units=response.units, notes=tuple(notes),
        fingerprint={"data": digest([data.capacity, data.capacity_sd, list(runs.session), list(runs.condition)]),
                     "model": digest([response.fingerprint, form])},
    )  # fmt: skip
