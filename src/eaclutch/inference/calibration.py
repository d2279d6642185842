"""Simulation-based calibration (Talts et al. 2018, arXiv:1804.06788) of a stage: is the posterior what it says?

For each replication parameters are drawn from the prior, data from the likelihood at them, the posterior is sampled,
and the rank of the true value among posterior draws is noted. Ranks are uniform if prior, likelihood and sampler
belong together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import beta

from eaclutch.inference.problem import Problem
from eaclutch.inference.sampling import SamplerSettings, sample
from eaclutch.records import FloatArray

DRAWS = 99  # posterior draws a rank counts in: ranks 0 .. 99
COVERAGE = 0.9
FAMILY_ERROR = 0.05


@dataclass(frozen=True)
class Replicable:
    """A stage's problem and how it looks with other data: rebuild(observed) -> Problem."""

    problem: Problem
    rebuild: Callable[[FloatArray], Problem]


def replications(
    case: Replicable, settings: SamplerSettings, seed: int, numbers: Iterable[int]
) -> dict[str, Any]:
    """Ranks {parameter: [...]} of the replications ``numbers`` (each has its own seed), and how many converged."""
    names = case.problem.priors.names
    ranks: dict[str, list[int]] = {name: [] for name in names}
    converged = 0
    for number in numbers:
        rng = np.random.default_rng([seed, number])
        theta = _possible(case.problem, rng)
        assert case.problem.predictive is not None
        data = case.problem.predictive(theta, rng, posterior=False)[0]
        found = sample(case.rebuild(data), settings, int(rng.integers(2**31)))
        converged += found.converged
        rows = np.linspace(0, len(found.flat) - 1, DRAWS).round().astype(int)
        below = np.sum(found.flat[rows] < theta[0], axis=0)
        for name, rank in zip(names, below, strict=True):
            ranks[name].append(int(rank))
    return {"stage": case.problem.stage, "ranks": ranks, "converged": converged}


def _possible(problem: Problem, rng: np.random.Generator, tries: int = 100) -> FloatArray:
    """A prior draw (1, params) at which the data are possible (the likelihood of the observed data is finite)."""
    assert problem.log_likelihood is not None
    for _ in range(tries):
        theta = problem.priors.sample(rng, 1)
        if np.isfinite(problem.log_likelihood(theta)[0]):
            return theta
    raise ValueError(f"{problem.stage}: no prior draw has a finite likelihood")


def verdict(ranks: Mapping[str, Iterable[int]], rng: np.random.Generator) -> dict[str, Any]:
    """Per parameter: largest distance of the ranks' distribution from uniform against the simultaneous limit over
    all parameters (family error 5 %), and coverage of the central 90 % interval with its binomial interval."""
    arrays = {name: np.asarray(list(values)) for name, values in ranks.items()}
    count = len(next(iter(arrays.values())))
    null = rng.integers(0, DRAWS + 1, size=(4000, count))
    limit = float(np.quantile(_distance(null), 1 - FAMILY_ERROR / len(arrays)))
    rows = {}
    for name, values in arrays.items():
        tail = (1 - COVERAGE) / 2
        share = (values + 0.5) / (DRAWS + 1)
        inside = int(np.sum((share > tail) & (share < 1 - tail)))
        low = float(beta.ppf(0.05, inside, count - inside + 1)) if inside else 0.0
        high = float(beta.ppf(0.95, inside + 1, count - inside)) if inside < count else 1.0
        distance = float(_distance(values[None])[0])
        rows[name] = {
            "distance": distance, "limit": limit, "inside_band": distance <= limit, "coverage_90": inside / count,
            "coverage_low": low, "coverage_high": high,
        }  # fmt: skip
    return {
        "replications": count, "passed": all(row["inside_band"] for row in rows.values()), "parameters": rows,
    }  # fmt: skip


def _distance(ranks: np.ndarray) -> FloatArray:
    """Largest distance (sets,) between the distribution of ranks (sets, replications) and the uniform one."""
    edges = np.arange(DRAWS + 1)
    counts = np.stack([np.sum(ranks <= edge, axis=1) for edge in edges], axis=1) / ranks.shape[1]
    return np.max(np.abs(counts - (edges + 1) / (DRAWS + 1)), axis=1)
