"""Joint fit of one hypothesis: calibrated parameters and the effect's own, on the whole data vector.

Evidence is Laplace's in the priors' standard normal coordinates, averaged over how large the tolerance and the
session spread of this campaign are (a small grid in the thresholds file), so that no hypothesis lives or dies
by one assumed size.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtri
from scipy.stats import qmc

from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.evidence import marginal_evidence
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.gaussian import Linearised
from eaclutch.diagnosis.mode import Mode, find_mode, mode_at
from eaclutch.physics.effects import EFFECTS
from eaclutch.records import FloatArray

SCOUTS = 64  # parameter sets of an effect tried before the fit
SCOUT_WIDTH = 1.3  # in prior sds
NEARLY_OFF = -1.5  # prior sds: a half-normal amplitude at a sixth of its scale, for zero lies out of reach
SPREAD = 0.7  # prior sds, of the draws that a fit from scratch looks at
BASE_STARTS = 4  # draws that a fit from scratch starts from, besides the defaults
STARTS = 1  # of which so many are fitted
ROUNDS = 2  # fits, each around a gap of the size that the one before found
LARGEST_CHANGE = np.log(3.0)  # of that size from which another round is worth it


@dataclass(frozen=True)
class HypothesisFit:
    """A fitted hypothesis.

    effects: the candidates on top of the campaign's model. linearised: at the mode, with the covariance of
    the most probable multipliers; usual: the same with no wider a tolerance than an evidence may take.
    residual (entries,): measured less predicted at the mode. signature (entries,): how far the effects themselves
    move the prediction; form: of that, what another form of their laws might move. multipliers: the most probable
    (tolerance, session). log_evidence: nats, averaged over the multipliers. peak: that of the most probable
    multipliers, however wide; fits of one hypothesis from different starts are compared by it.
    """

    effects: tuple[str, ...]
    mode: Mode
    linearised: Linearised
    usual: Linearised
    residual: FloatArray
    signature: FloatArray
    form: FloatArray
    multipliers: tuple[float, float]
    log_evidence: float
    peak: float
    size: tuple[float, float]

    @property
    def parameters(self) -> dict[str, float]:
        return dict(zip(self.mode.names, self.mode.theta.tolist(), strict=True))


def fit_hypothesis(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    *,
    base: HypothesisFit | None = None,
    beyond: HypothesisFit | None = None,
    seeds: Mapping[str, float] | None = None,
    size: tuple[float, float] = (1.0, 1.0),
) -> HypothesisFit:
    """Fit ``forward``'s hypothesis, starting from the base fit where there is one.

    An effect's own parameters are scouted over their prior first (the calibrated ones follow linearly), so
    that a fit does not depend on where it starts; on top of the fit of one of two effects, ``beyond`` which it goes,
    the other one's are. ``seeds``: parameters known from elsewhere (the fits of each of two effects alone; a first fit
    of the same data) make a further start, and the only one of a fit from scratch. ``size``: multipliers (tolerance,
    session) that it begins with, where another fit has found how large the gap is.
    """
    share = thresholds["signature_tolerance"]
    best: HypothesisFit | None = None
    for _ in range(ROUNDS):

        def covariance_at(theta: FloatArray, size: tuple[float, float] = size) -> FloatArray:
            tolerance, session = size
            if not forward.candidates:
                return kernels.total(tolerance=tolerance, session=session)
            form = form_signature(forward, theta)
            return kernels.total(
                tolerance=tolerance, session=session, signature=form, signature_tolerance=share
            )

        found = [
            _finish(
                forward,
                data,
                kernels,
                thresholds,
                find_mode(forward, data.values, covariance_at, start),
                size,
            )
            for start in _starts(forward, data, kernels, size, base, beyond, seeds)
        ]
        best = max([*found, *([best] if best else [])], key=lambda fitted: fitted.peak)
        # around a gap of some size the base laws hold no better than that
        if abs(np.log(best.multipliers[0] / size[0])) < LARGEST_CHANGE:
            break
        size = best.multipliers
    assert best is not None
    return best


def plain_fit_at(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    u: FloatArray,
    size: tuple[float, float],
    converged: bool,
) -> HypothesisFit:
    """The fit of a hypothesis without candidates whose mode ``u`` (params,) and ``size`` are known: as it was found."""
    factor = cho_factor(kernels.total(tolerance=size[0], session=size[1]), lower=True)
    predicted = forward.predict(forward.priors.from_normal(u))[0]
    mode = mode_at(forward, u, factor, predicted, None, converged)
    return _finish(forward, data, kernels, thresholds, mode, size)


def _starts(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    size: tuple[float, float],
    base: HypothesisFit | None,
    beyond: HypothesisFit | None,
    seeds: Mapping[str, float] | None,
) -> list[FloatArray]:
    """Where the fits of one hypothesis start, in prior coordinates."""
    covariance = kernels.total(tolerance=size[0], session=size[1])
    if base is not None:
        starts = _scout(forward, base, covariance)
    elif not seeds or size[0] > 1.0:
        starts = _prior_starts(forward, data, covariance)
    else:
        starts = []
    if beyond is not None:
        starts += _scout(forward, beyond, covariance)[1:]
    if seeds:
        known = np.array([seeds.get(p.name, p.default) for p in forward.parameters])
        # what is known stands in for the base fit, and does at least as well
        starts = [*starts[1:], np.clip(forward.priors.to_normal(known), -5.0, 5.0)]
    return starts


def _prior_starts(forward: Forward, data: DataVector, covariance: FloatArray) -> list[FloatArray]:
    """Where a fit from scratch starts: the defaults, and the best of many draws around them."""
    default = forward.priors.to_normal(np.array([p.default for p in forward.parameters]))
    points = qmc.Sobol(len(default), scramble=False).random(2 * SCOUTS)[1:]
    u = default + SPREAD * ndtri(np.clip(points, 1e-6, 1 - 1e-6))
    factor = cho_factor(covariance, lower=True)
    gap = data.values - forward.representative.predict(forward.priors.from_normal(u))
    cost = 0.5 * np.sum(gap.T * cho_solve(factor, gap.T), axis=0) + 0.5 * np.sum(u**2, axis=1)
    return [default, *(u[i] for i in np.argsort(cost)[:BASE_STARTS])]


def _finish(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    mode: Mode,
    size: tuple[float, float],
) -> HypothesisFit:
    signature = own_signature(forward, mode.theta)
    form = (
        form_signature(forward, mode.theta)
        if any(EFFECTS[e].exact for e in forward.candidates)
        else signature
    )
    residual = data.values - mode.predicted
    found = marginal_evidence(forward, data, kernels, thresholds, mode, form)
    w = residual + mode.jacobian @ mode.u

    def linearised(tolerance: float) -> Linearised:
        covariance = kernels.total(
            tolerance=tolerance, session=found.multipliers[1],
            signature=form, signature_tolerance=thresholds["signature_tolerance"],
        )  # fmt: skip
        return Linearised(w, mode.jacobian, covariance)

    own = linearised(found.multipliers[0])
    widest = max(thresholds["multipliers"]["tolerance"]["values"])
    usual = own if found.multipliers[0] <= widest else linearised(widest)
    return HypothesisFit(
        forward.candidates, mode, own, usual, residual, signature, form,
        found.multipliers, found.log_evidence, found.peak, size,
    )  # fmt: skip


def own_signature(forward: Forward, theta: FloatArray) -> FloatArray:
    """How far the candidates move the prediction from neutral at ``theta``, (entries,)."""
    if not forward.candidates:
        return np.zeros(len(forward.data))
    neutral = neutral_parameters(forward, theta)
    both = forward.representative.predict(np.stack([theta, neutral]))
    return both[0] - both[1]


def form_signature(forward: Forward, theta: FloatArray) -> FloatArray:
    """``own_signature`` of the candidates whose law might have another form, (entries,)."""
    loose = [
        i
        for i, parameter in enumerate(forward.parameters)
        if forward.own(parameter.name) and not EFFECTS[parameter.name.split(".")[0]].exact
    ]
    if not loose:
        return np.zeros(len(forward.data))
    both = forward.representative.predict(np.stack([theta, neutral_parameters(forward, theta, loose)]))
    return both[0] - both[1]


def neutral_parameters(forward: Forward, theta: FloatArray, which: Sequence[int] | None = None) -> FloatArray:
    """``theta`` with the candidates' parameters, or ``which`` of them, at the value that switches an effect off."""
    out = np.array(theta, dtype=float)
    for i, parameter in enumerate(forward.parameters):
        if forward.own(parameter.name) and parameter.neutral is not None and (which is None or i in which):
            out[i] = parameter.neutral
    return out


def _scout(forward: Forward, base: HypothesisFit, covariance: FloatArray) -> list[FloatArray]:
    """Starts (params,) in prior coordinates: the best of many draws of the effect's own parameters, with the
    calibrated ones where they would follow linearly."""
    u, own = _scouts(forward, base)
    if not own:
        return [u[0]]
    shift, cost = scout_shifts(forward, base)
    factor = cho_factor(covariance + base.linearised.jacobian @ base.linearised.jacobian.T, lower=True)
    w = base.linearised.w - shift
    white = cho_solve(factor, w.T)
    score = -0.5 * np.sum(w.T * white, axis=0) - cost
    # the base fit itself comes first: a hypothesis that holds the base model must not do worse than it
    neutral = forward.priors.to_normal(neutral_parameters(forward, forward.priors.from_normal(u[0]), own))
    free = [p.neutral is None for p in forward.parameters]
    off = np.where(free, NEARLY_OFF, np.maximum(neutral, NEARLY_OFF))
    starts = [np.where([i in own for i in range(u.shape[1])], off, u[0])]
    for i in np.argsort(-score)[:STARTS]:
        followed = dict(zip(base.mode.names, base.linearised.jacobian.T @ white[:, i], strict=True))
        start = np.array([followed.get(name, u[i, k]) for k, name in enumerate(forward.priors.names)])
        starts.append(np.clip(start, -5.0, 5.0))
    return starts


def scout_shifts(forward: Forward, base: HypothesisFit) -> tuple[FloatArray, FloatArray]:
    """How far each scouted size of what ``forward`` has beyond ``base`` moves the entries, (scouts, entries), and its
    prior cost (scouts,) in nats."""
    u, own = _scouts(forward, base)
    theta = forward.priors.from_normal(u)
    neutral = neutral_parameters(forward, theta[0], own)
    predicted = forward.representative.predict(np.concatenate([theta, neutral[None]]))
    return predicted[:-1] - predicted[-1], 0.5 * np.sum(u[:, own] ** 2, axis=1)


def _scouts(forward: Forward, base: HypothesisFit) -> tuple[FloatArray, list[int]]:
    """Points (scouts, params) in prior coordinates: the base mode with draws of the candidates' own
    parameters that it lacks; and which those are."""
    known = dict(zip(base.mode.names, base.mode.u, strict=True))
    default = forward.priors.to_normal(np.array([p.default for p in forward.parameters]))
    mode = np.array([known.get(p.name, default[i]) for i, p in enumerate(forward.parameters)])
    own = [i for i, p in enumerate(forward.parameters) if forward.own(p.name) and p.name not in known]
    if not own:
        return mode[None], own
    u = np.tile(mode, (SCOUTS, 1))
    # wider than the prior: effects larger than expected are scouted too
    points = qmc.Sobol(len(own), scramble=False).random(2 * SCOUTS)[1 : SCOUTS + 1]
    u[:, own] = SCOUT_WIDTH * ndtri(np.clip(points, 1e-6, 1 - 1e-6))
    return u, own
