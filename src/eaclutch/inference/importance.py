"""A problem's posterior without a chain, where a few hundred draws do: a refit without some runs, a check."""

from __future__ import annotations

import numpy as np

from eaclutch.inference.moves import Target
from eaclutch.inference.problem import Problem
from eaclutch.inference.start import starting_walkers
from eaclutch.records import FloatArray

PROPOSALS = 2000


def resampled(problem: Problem, draws: int, rng: np.random.Generator) -> FloatArray:
    """Draws (draws, params): the mode is searched, draws of a Student t around it are reweighted to the posterior."""
    size = len(problem.priors)
    start = starting_walkers(problem.log_density, size, 4 * size, rng)
    target = Target(start.mode, start.root)
    random = np.random.RandomState(rng.integers(2**31))
    u, _ = target.jump(np.zeros((PROPOSALS, size)), random)
    weights = problem.log_density(u) - target.log_density(u)
    weights = np.exp(weights - weights.max())
    # systematic resampling: no more noise than the weights bring
    places = (np.arange(draws) + rng.uniform()) / draws * weights.sum()
    theta = problem.priors.from_normal(u[np.searchsorted(np.cumsum(weights), places).clip(0, PROPOSALS - 1)])
    return theta[rng.permutation(draws)]


def width_check(wider: Problem, rng: np.random.Generator) -> str:
    """What the wider law's additional parameter says about the narrow one, in a sentence; a true law is called too
    narrow once in a hundred times."""
    parameter = wider.priors.parameters[-1]
    assert parameter.neutral is not None
    values = resampled(wider, PROPOSALS // 2, rng)[:, -1]
    least, low, high, most = np.quantile(values, [0.005, 0.05, 0.95, 0.995])
    kept = "stands" if least <= parameter.neutral <= most else "is too narrow for these data"
    return (
        f"{parameter.name} {np.mean(values):.3g} (90 %: {low:.3g} to {high:.3g}):"
        f" the law without it, {parameter.neutral:g}, {kept}"
    )
