"""How probable a fitted hypothesis makes the data: Laplace's evidence over what a campaign's tolerance and session
spread may be, less what a linearised fit promises and the model does not keep."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import logsumexp

from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.gaussian import Linearised, log_normal, posterior_mean
from eaclutch.diagnosis.mode import Mode
from eaclutch.records import FloatArray

ON_THE_WAY = np.array([0.0, 0.25, 0.5, 1.0])  # from a fit's mode to where its linearisation would move
# Tolerances beyond those that an evidence may take: around a large gap a fit must not bend the calibrated parameters.
WIDER = (4.0, 8.0, 16.0)
NEGLIGIBLE = 6.0  # nats below the best, from which multipliers add next to nothing (a four-hundredth)


@dataclass(frozen=True)
class Evidence:
    """log_evidence (nats): averaged over the usual multipliers. peak: of the most probable ones, however wide.
    multipliers: these, (tolerance, session)."""

    log_evidence: float
    peak: float
    multipliers: tuple[float, float]


def marginal_evidence(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    mode: Mode,
    signature: FloatArray,
    above: float | None = None,
) -> Evidence | None:
    """Laplace's evidence at a mode over the grid of multipliers, each less what is ``unrealised`` there; None where its
    peak is not ``above`` that of another fit."""
    grid = thresholds["multipliers"]
    usual = dict(zip(grid["tolerance"]["values"], grid["tolerance"]["weights"], strict=True))
    sizes = [
        (float(t), float(s), np.log(usual[t] * p) if t in usual else -np.inf)
        for t in (*usual, *WIDER)
        for s, p in zip(grid["session"]["values"], grid["session"]["weights"], strict=True)
    ]
    w = data.values - mode.predicted + mode.jacobian @ mode.u

    def linearised(tolerance: float, session: float) -> Linearised:
        covariance = kernels.total(
            tolerance=tolerance, session=session,
            signature=signature, signature_tolerance=thresholds["signature_tolerance"],
        )  # fmt: skip
        return Linearised(w, mode.jacobian, covariance)

    promised = np.array([log_normal(w, linearised(t, s).marginal()) for t, s, _ in sizes])
    if above is not None and np.max(promised) <= above:
        return None
    prior = np.array([log_prior for *_, log_prior in sizes])
    kept = np.full(len(sizes), -np.inf)
    for i in np.argsort(-promised):
        # nothing is kept beyond what is promised: the rest cannot come near
        if (
            promised[i] < np.max(kept) - NEGLIGIBLE
            and promised[i] + prior[i] < np.max(kept + prior) - NEGLIGIBLE
        ):
            continue
        kept[i] = promised[i] - unrealised(forward, data, mode, linearised(*sizes[i][:2]))
    best = int(np.argmax(kept))
    if above is not None and kept[best] <= above:
        return None
    return Evidence(float(logsumexp(kept + prior)), float(kept[best]), sizes[best][:2])


def unrealised(forward: Forward, data: DataVector, mode: Mode, linearised: Linearised) -> float:
    """Nats that the linearised fit promises and the model does not keep, at least 0.

    Another covariance than the fit's has its mode elsewhere, and a model that jumps (a run on the verge of sticking)
    promises by its slopes what no step brings: what counts is the best of the points on the way to the promised one.
    """
    promised_at = posterior_mean(linearised)
    u = mode.u + ON_THE_WAY[:, None] * (promised_at - mode.u)
    residual = data.values - np.vstack([mode.predicted, forward.predict(forward.priors.from_normal(u[1:]))])
    white = cho_solve(cho_factor(linearised.covariance, lower=True), residual.T)
    kept = 0.5 * np.sum(residual.T * white, axis=0) + 0.5 * np.sum(u**2, axis=1)
    promised = 0.5 * float(linearised.w @ np.linalg.solve(linearised.marginal(), linearised.w))
    return max(float(np.min(kept)) - promised, 0.0)
