"""An independent sampler on the same posterior: nested sampling (dynesty, doi:10.1093/mnras/staa278)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from dynesty import NestedSampler
from scipy.special import ndtri

from eaclutch.inference.convergence import Thresholds
from eaclutch.inference.problem import Problem
from eaclutch.inference.sampling import SamplerSettings, sample
from eaclutch.records import FloatArray

EFFECTIVE = 4000.0  # draws on both sides
MEAN_WITHIN = 0.1  # posterior sds
SD_WITHIN = 0.1  # share


def nested(problem: Problem, seed: int, live: int = 1000) -> tuple[FloatArray, FloatArray, float]:
    """Mean and sd (params,) in the priors' normal coordinates, and the effective number of draws."""
    assert problem.log_likelihood is not None
    likelihood, priors = problem.log_likelihood, problem.priors

    def log_likelihood(u: FloatArray) -> float:
        value = float(likelihood(priors.from_normal(u[None]))[0])
        return value if np.isfinite(value) else -1e300

    sampler = NestedSampler(
        log_likelihood,
        lambda cube: ndtri(np.clip(cube, 1e-15, 1 - 1e-15)),
        len(priors),
        nlive=live,
        sample="unif",
        bootstrap=0,
        enlarge=1.5,  # of the ellipsoids' volume: bounds that cut off tails would narrow the posterior
        rstate=np.random.default_rng(seed),
    )
    sampler.run_nested(print_progress=False, dlogz=0.01)
    found = sampler.results
    weights = found.importance_weights()
    mean = weights @ found.samples
    sd = np.sqrt(weights @ (found.samples - mean) ** 2)
    return mean, sd, float(1.0 / np.sum(weights**2))


def agreement(
    problem: Problem, settings: SamplerSettings, seed: int, effective: float = EFFECTIVE
) -> dict[str, Any]:
    """Means and sds of both samplers by parameter, and whether they agree: means within 0.1 sd, sds within 10 %."""
    thresholds: Thresholds = replace(settings.thresholds, ess=effective)
    ours = sample(problem, replace(settings, thresholds=thresholds), seed)
    u = problem.priors.to_normal(ours.flat)
    mean, sd = u.mean(axis=0), u.std(axis=0)
    live, count = int(effective / 4), 0.0
    while True:
        other_mean, other_sd, count = nested(problem, seed, live)
        if count >= effective or live >= 2 * effective:
            break
        live *= 2
    rows = {}
    for i, name in enumerate(problem.priors.names):
        shift, ratio = float((other_mean[i] - mean[i]) / sd[i]), float(other_sd[i] / sd[i])
        rows[name] = {
            "mean_shift_sd": shift, "sd_ratio": ratio,
            "agrees": abs(shift) <= MEAN_WITHIN and abs(ratio - 1) <= SD_WITHIN,
        }  # fmt: skip
    return {
        "stage": problem.stage, "converged": ours.converged, "effective_draws": min(
            float(ours.diagnostics.ess_bulk.min()), float(ours.diagnostics.ess_tail.min())
        ),
        "effective_draws_nested": count, "parameters": rows,
        "passed": bool(ours.converged and count >= effective and all(row["agrees"] for row in rows.values())),
    }  # fmt: skip
