"""Draws of the force stage without some runs: a quick refit, so that their prediction has not seen them.

Its draws (`importance`) carry the other stages' parameters along. Only this stage looks at the runs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from eaclutch.inference.importance import resampled
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem
from eaclutch.inference.response import Response
from eaclutch.inference.stages.force import MULTIPLIER, VOLTAGE_PRIOR, CapacityData, force_problem
from eaclutch.physics.effect import Parameter
from eaclutch.records import FloatArray


def refit_draws(problem: Problem, draws: int, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Draws {name: (draws,)} of a force problem with its derived parameters, by importance resampling."""
    size = len(problem.priors)
    if size == 0 or not problem.has_data:
        theta = problem.priors.sample(rng, draws) if size else np.zeros((draws, 0))
    else:
        theta = resampled(problem, draws, rng)
    found = {name: theta[:, i] for i, name in enumerate(problem.priors.names)}
    if problem.derived is not None:
        found |= problem.derived(theta, rng)
    return found


def unseen_voltages(
    names: Iterable[str], refit: Mapping[str, FloatArray], draws: int, rng: np.random.Generator
) -> dict[str, FloatArray]:
    """Prior draws of those voltages' multipliers among ``names`` that the refit has no run of."""
    unseen = [name for name in names if name.startswith(MULTIPLIER) and name not in refit]
    own = [Parameter(name, "1", (0.0, np.inf), 1.0, VOLTAGE_PRIOR) for name in unseen]
    values = Priors.of(own).sample(rng, draws) if own else np.zeros((draws, 0))
    return {name: values[:, i] for i, name in enumerate(unseen)}


def without(
    data: CapacityData, response: Response, keep: np.ndarray, form: str, parameters: dict[str, Parameter]
) -> Problem:
    """The force problem of the runs ``keep`` (mask or indices)."""
    rows = np.arange(len(data.capacity))[keep]
    part = CapacityData(data.conditions.select(rows), data.capacity[rows], data.capacity_sd[rows])
    return force_problem(part, response.select(rows), form, parameters)  # type: ignore[arg-type]


def folds(labels: Sequence[str], parts: int, rng: np.random.Generator) -> list[set[str]]:
    """The labels split at random into at most ``parts`` sets, none empty."""
    distinct = sorted(set(labels))
    rng.shuffle(distinct)
    return [set(distinct[i::parts]) for i in range(min(parts, len(distinct)))]
