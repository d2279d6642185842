"""Finalists sampled in full: does Laplace's approximation, by which all candidates are weighed, hold for the best?

The density is that of the fit (covariance at its most probable multipliers), its parameters are sampled by emcee from
the fit's mode, and the evidence is importance-sampled with a Student t around the draws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import gammaln, logsumexp

from eaclutch.diagnosis.evidence import unrealised
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.gaussian import log_normal, posterior_sd
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.readings import PREFIX
from eaclutch.diagnosis.study import Study
from eaclutch.inference.moves import DEGREES_OF_FREEDOM, Target
from eaclutch.inference.problem import Problem, digest
from eaclutch.inference.sampling import Sampled
from eaclutch.records import FloatArray

Effects = tuple[str, ...]
TOGETHER = 100  # parameter vectors that are predicted at once
PROPOSALS = 4000


def finalists(diagnosis: Mapping[str, Any], most: int = 3) -> list[Effects]:
    """The base model and the most probable sets of effects of a diagnosis.json, ``most`` at most."""
    order = sorted(diagnosis["hypotheses"], key=lambda entry: -entry["probability"])
    named = [tuple(entry["effects"]) for entry in order if entry["effects"] not in ([], ["unknown"])]
    return [(), *named[:most]]


def fit_of(study: Study, effects: Effects, diagnosis: Mapping[str, Any]) -> HypothesisFit:
    """The finalist's fit; a pair's is also started from what the diagnosis found of each of its effects alone."""
    known = {cause["effect"]: cause.get("parameters", {}) for cause in diagnosis["causes"]}
    seeds = {
        f"{effect}.{name}": float(entry["mean"])
        for effect in effects
        for name, entry in known.get(effect, {}).items()
    }
    return study.fit(effects, seeds if len(effects) > 1 else None)


def problem_of(study: Study, fitted: HypothesisFit) -> Problem:
    """The finalist's posterior as the sampler sees it."""
    forward, covariance = study.forward(fitted.effects), fitted.linearised.covariance
    values = study.data.values
    factor = cho_factor(covariance, lower=True)
    root = np.linalg.cholesky(covariance)
    precision = cho_solve(factor, np.eye(len(values)))
    constant = -float(np.sum(np.log(np.diag(factor[0])))) - 0.5 * len(values) * np.log(2 * np.pi)

    def residual(theta: FloatArray) -> FloatArray:
        return values - _predict(forward, theta)

    def log_likelihood(theta: FloatArray) -> FloatArray:
        gap = residual(theta)
        found: FloatArray = constant - 0.5 * np.einsum("de,ef,df->d", gap, precision, gap, optimize=True)
        return found

    def pointwise(theta: FloatArray) -> FloatArray:
        weight = np.diag(precision)
        gap = residual(theta) @ precision / weight
        return 0.5 * np.log(weight / (2 * np.pi)) - 0.5 * weight * gap**2

    def predictive(theta: FloatArray, rng: np.random.Generator, posterior: bool = True) -> FloatArray:
        return _predict(forward, theta) + rng.standard_normal((len(theta), len(values))) @ root.T

    return Problem(
        "diagnosis", forward.priors, log_likelihood, pointwise, predictive, values,
        data_name="entries", data_unit="comparison scale",
        coords={"channel": study.data.channel.astype(str), "condition": study.data.condition.astype(str),
                "session": study.data.session.astype(str)},
        redrawn=tuple(name for name in forward.priors.names if name.startswith(PREFIX)),
        fingerprint={"data": digest([values, covariance]), "model": digest(list(fitted.effects))},
    )  # fmt: skip


def compared(
    study: Study, fitted: HypothesisFit, sampled: Sampled, rng: np.random.Generator
) -> dict[str, Any]:
    """One finalist of full.json: its evidence and parameters by sampling and by Laplace."""
    problem, mode, linearised = sampled.problem, fitted.mode, fitted.linearised
    u = problem.priors.to_normal(sampled.flat)
    evidence, sd, draws = importance_evidence(problem, u, rng)
    lost = unrealised(study.forward(fitted.effects), study.data, mode, linearised)
    laplace, spread = posterior_sd(linearised), fitted.sd  # prior sds, natural units
    rows = {
        name: {
            "mean": float(sampled.flat[:, i].mean()), "sd": float(sampled.flat[:, i].std()),
            "laplace_mean": float(mode.theta[i]), "laplace_sd": float(spread[i]),
            "shift_sd": float((u[:, i].mean() - mode.u[i]) / laplace[i]),
            "sd_ratio": float(u[:, i].std() / laplace[i]),
        }
        for i, name in enumerate(problem.priors.names)
    }  # fmt: skip
    found = sampled.diagnostics
    return {
        "effects": list(fitted.effects), "log_evidence": evidence, "log_evidence_sd": sd, "evidence_draws": draws,
        "log_evidence_laplace": log_normal(linearised.w, linearised.marginal()) - lost,
        "converged": sampled.converged, "failures": list(sampled.failures), "steps": sampled.total_steps,
        "r_hat_max": float(np.max(found.r_hat)), "ess_min": float(min(found.ess_bulk.min(), found.ess_tail.min())),
        "multipliers": list(fitted.multipliers), "parameters": rows,
    }  # fmt: skip


def importance_evidence(
    problem: Problem, u: FloatArray, rng: np.random.Generator
) -> tuple[float, float, float]:
    """Log evidence [nats], its standard error and the effective number of draws behind it.

    ``u`` (draws, params): posterior draws in the priors' normal coordinates, around which a Student t proposes.
    """
    target, size = Target.of(u), u.shape[1]
    proposal, _ = target.jump(np.zeros((PROPOSALS, size)), np.random.RandomState(rng.integers(2**31)))
    nu = DEGREES_OF_FREEDOM
    norm = gammaln(0.5 * (nu + size)) - gammaln(0.5 * nu) - 0.5 * size * np.log(nu * np.pi)
    norm -= float(np.sum(np.log(np.diag(target.root))))
    prior = -0.5 * size * np.log(2 * np.pi)
    log_weight = problem.log_density(proposal) + prior - target.log_density(proposal) - norm
    evidence = float(logsumexp(log_weight) - np.log(PROPOSALS))
    weight = np.exp(log_weight - log_weight.max())
    draws = float(weight.sum() ** 2 / np.sum(weight**2))
    return evidence, float(np.sqrt(max(1.0 / draws - 1.0 / PROPOSALS, 0.0))), draws


def document(
    rows: Sequence[Mapping[str, Any]], diagnosis: Mapping[str, Any], temperature: float
) -> dict[str, Any]:
    """full.json: the finalists, and their probabilities with the sampled evidence in Laplace's place.

    Probabilities are among the finalists alone, before and after.
    """
    before = {tuple(entry["effects"]): float(entry["probability"]) for entry in diagnosis["hypotheses"]}
    kept = [max(before.get(tuple(row["effects"]), 0.0), 1e-300) for row in rows]
    moved = [(row["log_evidence"] - row["log_evidence_laplace"]) / temperature for row in rows]
    after = np.log(kept) + np.array(moved)
    after = np.exp(after - logsumexp(after))
    found = [
        {**row, "probability_laplace": share / sum(kept), "probability": float(weight)}
        for row, share, weight in zip(rows, kept, after, strict=True)
    ]
    return {"schema": 1, "finalists": found}


def _predict(forward: Forward, theta: FloatArray) -> FloatArray:
    pieces = np.array_split(np.arange(len(theta)), max(1, -(-len(theta) // TOGETHER)))
    return np.concatenate([forward.predict(theta[piece]) for piece in pieces])
