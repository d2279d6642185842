"""How probable a fitted hypothesis makes the data: Laplace's evidence over what a campaign's tolerance and session
spread may be, less what a linearised fit promises and the model does not keep."""

from __future__ import annotations

from collections.abc import Mapping
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


def marginal_evidence(
    w: FloatArray,
    jacobian: FloatArray,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    signature: FloatArray,
) -> tuple[float, tuple[float, float], float, tuple[float, float]]:
    """Evidence averaged over the usual multipliers, the best of these, the largest of all, and where it is."""
    grid = thresholds["multipliers"]
    prior = jacobian @ jacobian.T
    usual = dict(zip(grid["tolerance"]["values"], grid["tolerance"]["weights"], strict=True))
    scores, weighted, pairs, usual_pairs = [], [], [], []
    for t in (*usual, *WIDER):
        for s, p_s in zip(grid["session"]["values"], grid["session"]["weights"], strict=True):
            covariance = kernels.total(
                tolerance=t, session=s, signature=signature,
                signature_tolerance=thresholds["signature_tolerance"],
            )  # fmt: skip
            scores.append(log_normal(w, covariance + prior))
            pairs.append((float(t), float(s)))
            if t in usual:
                weighted.append(scores[-1] + np.log(usual[t] * p_s))
                usual_pairs.append(pairs[-1])
    best = int(np.argmax(scores))
    return (
        float(logsumexp(weighted)),
        usual_pairs[int(np.argmax(weighted))],
        float(scores[best]),
        pairs[best],
    )


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
