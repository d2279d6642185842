"""Joint fit of one hypothesis: calibrated parameters and the effect's own, on the whole data vector.

Evidence is Laplace's in the priors' standard normal coordinates, averaged over how large the tolerance and the
session spread of this campaign are (a small grid in the thresholds file), so that no hypothesis lives or dies
by one assumed size.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.special import logsumexp, ndtri
from scipy.stats import qmc

from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.gaussian import Linearised, log_normal
from eaclutch.inference import laplace
from eaclutch.records import FloatArray

SCOUTS = 64  # parameter sets of an effect tried before the fit
SCOUT_WIDTH = 1.3  # in prior sds
STARTS = 2  # of which so many are fitted


@dataclass(frozen=True)
class HypothesisFit:
    """A fitted hypothesis.

    effects: the candidates on top of the campaign's model. linearised: at the mode, with the covariance of
    the most probable multipliers. residual (entries,): measured less predicted at the mode. signature
    (entries,): how far the effects themselves move the prediction. laplace: the fit's own record.
    multipliers: the most probable (tolerance, session). log_evidence: nats, averaged over the multipliers.
    """

    effects: tuple[str, ...]
    linearised: Linearised
    residual: FloatArray
    signature: FloatArray
    laplace: laplace.LaplaceFit
    multipliers: tuple[float, float]
    log_evidence: float

    @property
    def parameters(self) -> dict[str, float]:
        return dict(zip(self.laplace.names, self.laplace.mode.tolist(), strict=True))


def fit_hypothesis(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    *,
    base: HypothesisFit | None = None,
) -> HypothesisFit:
    """Fit ``forward``'s hypothesis, starting from the base fit where there is one.

    An effect's own parameters are scouted over their prior first (the calibrated ones follow linearly), so
    that a fit does not depend on where it starts.
    """
    starts = [None] if base is None else _scout(forward, data, base)
    best: tuple[laplace.LaplaceFit, FloatArray, FloatArray] | None = None
    for start in starts:
        found = _fit_from(forward, data, kernels, thresholds, start)
        if best is None or found[0].log_evidence > best[0].log_evidence:
            best = found
    if best is None:
        raise ValueError("no start could be fitted")
    fitted, root, signature = best
    jacobian = -root @ fitted.jacobian
    residual = data.values - forward.predict(fitted.mode)[0]
    w = residual + jacobian @ fitted.u_mode
    evidence, multipliers = _marginal_evidence(w, jacobian, kernels, thresholds, signature)
    covariance = kernels.total(
        tolerance=multipliers[0], session=multipliers[1],
        signature=signature, signature_tolerance=thresholds["signature_tolerance"],
    )  # fmt: skip
    return HypothesisFit(
        forward.candidates,
        Linearised(w, jacobian, covariance),
        residual,
        signature,
        fitted,
        multipliers,
        evidence,
    )


def _fit_from(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    start: FloatArray | None,
) -> tuple[laplace.LaplaceFit, FloatArray, FloatArray]:
    """Two rounds: the second with the tolerance of the effect's own signature at the first one's mode."""
    signature = np.zeros(len(data)) if start is None else own_signature(forward, start)
    rounds = 1 if not forward.candidates else 2
    for _ in range(rounds):
        covariance = kernels.total(signature=signature, signature_tolerance=thresholds["signature_tolerance"])
        root = np.linalg.cholesky(covariance)
        norm = -float(np.sum(np.log(np.diag(root)))) - 0.5 * len(data) * np.log(2 * np.pi)

        def residual(theta: FloatArray, root: FloatArray = root) -> FloatArray:
            gap = data.values - forward.predict(theta)
            return solve_triangular(root, gap.T, lower=True).T

        fitted = laplace.fit(
            residual, forward.priors, start=start, log_norm=norm, max_iterations=8, tolerance=1e-2
        )
        start = fitted.mode
        if forward.candidates:
            signature = own_signature(forward, fitted.mode)
    return fitted, root, signature


def own_signature(forward: Forward, theta: FloatArray) -> FloatArray:
    """How far the candidates move the prediction from neutral at ``theta``, (entries,)."""
    if not forward.candidates:
        return np.zeros(len(forward.data))
    neutral = neutral_parameters(forward, theta)
    both = forward.predict(np.stack([theta, neutral]))
    return both[0] - both[1]


def neutral_parameters(forward: Forward, theta: FloatArray) -> FloatArray:
    """``theta`` with every candidate at the value that switches it off."""
    out = np.array(theta, dtype=float)
    for i, parameter in enumerate(forward.parameters):
        if forward.own(parameter.name) and parameter.neutral is not None:
            out[i] = parameter.neutral
    return out


def _scout(forward: Forward, data: DataVector, base: HypothesisFit) -> list[FloatArray]:
    """Full parameter vectors to start from: the base fit's with the best of many draws of the effect's own."""
    theta, own = _scouts(forward, base)
    if not own:
        return [theta[0]]
    shift, cost = scout_shifts(forward, base)
    factor = cho_factor(base.linearised.marginal(), lower=True)
    w = base.linearised.w - shift
    score = -0.5 * np.sum(w.T * cho_solve(factor, w.T), axis=0) - cost
    return [theta[i] for i in np.argsort(-score)[:STARTS]]


def scout_shifts(forward: Forward, base: HypothesisFit) -> tuple[FloatArray, FloatArray]:
    """How far each scouted size of the candidates moves the entries, (scouts, entries), and its prior cost
    (scouts,) in nats."""
    theta, own = _scouts(forward, base)
    neutral = neutral_parameters(forward, theta[0])
    predicted = forward.predict(np.concatenate([theta, neutral[None]]))
    cost = 0.5 * np.sum(forward.priors.to_normal(theta)[:, own] ** 2, axis=1)
    return predicted[:-1] - predicted[-1], cost


def _scouts(forward: Forward, base: HypothesisFit) -> tuple[FloatArray, list[int]]:
    """Parameter vectors (scouts, params): the base mode with draws of the candidates' own; which are own."""
    mode = np.array([base.parameters.get(p.name, p.default) for p in forward.parameters])
    own = [i for i, p in enumerate(forward.parameters) if forward.own(p.name)]
    if not own:
        return mode[None], own
    points = qmc.Sobol(len(own), scramble=False).random(SCOUTS + 1)[1:]
    u = np.zeros((SCOUTS, len(mode)))
    # wider than the prior: effects larger than expected are scouted too
    u[:, own] = SCOUT_WIDTH * ndtri(np.clip(points, 1e-6, 1 - 1e-6))
    theta = forward.priors.from_normal(u)
    keep = [i for i in range(len(mode)) if i not in own]
    theta[:, keep] = mode[keep]
    return theta, own


def _marginal_evidence(
    w: FloatArray,
    jacobian: FloatArray,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    signature: FloatArray,
) -> tuple[float, tuple[float, float]]:
    grid = thresholds["multipliers"]
    prior = jacobian @ jacobian.T
    scores, pairs = [], []
    for t, p_t in zip(grid["tolerance"]["values"], grid["tolerance"]["weights"], strict=True):
        for s, p_s in zip(grid["session"]["values"], grid["session"]["weights"], strict=True):
            covariance = kernels.total(
                tolerance=t, session=s, signature=signature,
                signature_tolerance=thresholds["signature_tolerance"],
            )  # fmt: skip
            scores.append(log_normal(w, covariance + prior) + np.log(p_t * p_s))
            pairs.append((float(t), float(s)))
    return float(logsumexp(scores)), pairs[int(np.argmax(scores))]
