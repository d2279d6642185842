"""Draws of the force stage without some runs: a quick refit, so that their prediction has not seen them.

The stage without the runs is searched for its mode; draws of the Gaussian around it are reweighted to the posterior
(importance resampling) and carry the other stages' parameters along. Only this stage looks at the runs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from eaclutch.inference.moves import Target
from eaclutch.inference.problem import Problem
from eaclutch.inference.response import Response
from eaclutch.inference.stages.force import CapacityData, force_problem
from eaclutch.inference.start import starting_walkers
from eaclutch.physics.effect import Parameter
from eaclutch.records import FloatArray

PROPOSALS = 2000


def refit_draws(problem: Problem, draws: int, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Draws {name: (draws,)} of a force problem with its derived parameters, by importance resampling."""
    size = len(problem.priors)
    if size == 0 or not problem.has_data:
        theta = problem.priors.sample(rng, draws) if size else np.zeros((draws, 0))
    else:
        start = starting_walkers(problem.log_density, size, 4 * size, rng)
        target = Target(start.mode, start.root)
        random = np.random.RandomState(rng.integers(2**31))
        u, _ = target.jump(np.zeros((PROPOSALS, size)), random)
        weights = problem.log_density(u) - target.log_density(u)
        weights = np.exp(weights - weights.max())
        # systematic resampling: no more noise than the weights bring
        places = (np.arange(draws) + rng.uniform()) / draws * weights.sum()
        theta = problem.priors.from_normal(
            u[np.searchsorted(np.cumsum(weights), places).clip(0, PROPOSALS - 1)]
        )
        theta = theta[rng.permutation(draws)]
    found = {name: theta[:, i] for i, name in enumerate(problem.priors.names)}
    if problem.derived is not None:
        found |= problem.derived(theta, rng)
    return found


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
