"""Where the fits of a hypothesis start.

An effect's own parameters are scouted over their prior from the fit of the model without it, the calibrated ones
following linearly; a fit from scratch starts from the defaults and the best of draws around them. Where that other
fit is far off its parameters are bent, and what follows from them leads nowhere: an effect by itself also starts from
the defaults.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtri
from scipy.stats import qmc

from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.hypothesis import HypothesisFit, effect_shifts, neutral_parameters
from eaclutch.diagnosis.readings import PREFIX
from eaclutch.records import FloatArray

SCOUTS = 64  # parameter sets of an effect tried before the fit
SCOUT_WIDTH = 1.3  # in prior sds
NEARLY_OFF = -1.5  # prior sds: a half-normal amplitude at a sixth of its scale, for zero lies out of reach
SPREAD = 0.7  # prior sds, of the draws that a fit from scratch looks at
BASE_STARTS = 4  # draws that a fit from scratch starts from, besides the defaults
OTHER_ZEROS = (-1.5, -0.75, 0.75, 1.5)  # prior sds by which a session's zero is tried farther on
STARTS = 1  # scouted ones of which so many are fitted


def starts(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    size: tuple[float, float],
    base: HypothesisFit | None,
    beyond: HypothesisFit | None,
    seeds: Mapping[str, float] | None,
    widest: float,
) -> list[FloatArray]:
    """Where the fits of one hypothesis start, (params,) each in prior coordinates.

    base, beyond, seeds: as for ``fit.fit_hypothesis``; size: multipliers (tolerance, session) of the fit to come;
    widest: tolerance multiplier from which on a base fit counts as far off.
    """
    covariance = kernels.total(tolerance=size[0], session=size[1])
    if base is not None:
        found = scout(forward, base, covariance)
        if base.multipliers[0] >= widest and beyond is None and not seeds:
            found += _defaults(forward, base)
    elif not seeds or size[0] > 1.0:
        found = _prior_starts(forward, data, covariance)
    else:
        found = []
    if beyond is not None:
        found += scout(forward, beyond, covariance)[1:]
    if seeds:
        known = np.array([seeds.get(p.name, p.default) for p in forward.parameters])
        # what is known stands in for the base fit, and does at least as well
        found = [*found[1:], np.clip(forward.priors.to_normal(known), -5.0, 5.0)]
    return found


def _defaults(forward: Forward, base: HypothesisFit) -> list[FloatArray]:
    """The defaults, and the same with the load cell's zeros where the base fit found them, which other parameters may
    have bent or not."""
    names, default = forward.priors.names, forward.priors.to_normal(_default_values(forward))
    zeros = {n: u for n, u in zip(base.mode.names, base.mode.u, strict=True) if n.startswith(PREFIX)}
    read = np.array([zeros.get(name, u) for name, u in zip(names, default, strict=True)])
    return [default, read] if zeros else [default]


def _default_values(forward: Forward) -> FloatArray:
    return np.array([p.default for p in forward.parameters])


def _prior_starts(forward: Forward, data: DataVector, covariance: FloatArray) -> list[FloatArray]:
    """Where a fit from scratch starts: the defaults, and the best of many draws around them."""
    default = forward.priors.to_normal(_default_values(forward))
    points = qmc.Sobol(len(default), scramble=False).random(2 * SCOUTS)[1:]
    u = default + SPREAD * ndtri(np.clip(points, 1e-6, 1 - 1e-6))
    factor = cho_factor(covariance, lower=True)
    gap = data.values - forward.representative.predict(forward.priors.from_normal(u))
    cost = 0.5 * np.sum(gap.T * cho_solve(factor, gap.T), axis=0) + 0.5 * np.sum(u**2, axis=1)
    return [default, *(u[i] for i in np.argsort(cost)[:BASE_STARTS])]


def other_zeros(forward: Forward, u: FloatArray) -> list[FloatArray]:
    """Starts (params,) beside a fit's mode ``u``, each with another zero of one session. Where a zero leaves a session
    no preload the model stands still, and no slope leads a fit back to where it does."""
    zeros = [i for i, name in enumerate(forward.priors.names) if name.startswith(PREFIX)]
    unit = np.eye(len(u))
    return [u + farther * unit[i] for i in zeros for farther in OTHER_ZEROS]


def scout(forward: Forward, base: HypothesisFit, covariance: FloatArray) -> list[FloatArray]:
    """Starts (params,) in prior coordinates: the best of many draws of the effect's own parameters, with the
    calibrated ones where they would follow linearly."""
    u, own = _scouts(forward, base)
    if not own:
        return [u[0]]
    shift, cost = scout_shifts(forward, base)
    known = base.linearised
    score, followers = following(known.w - shift, known.jacobian, covariance, cost)
    # the base fit with the effect nearly off comes first: a hypothesis that holds the base model should not do worse
    neutral = forward.priors.to_normal(neutral_parameters(forward, forward.priors.from_normal(u[0]), own))
    free = [p.neutral is None for p in forward.parameters]
    off = np.where(free, NEARLY_OFF, np.maximum(neutral, NEARLY_OFF))
    found = [np.where([i in own for i in range(u.shape[1])], off, u[0])]
    for i in np.argsort(-score)[:STARTS]:
        followed = dict(zip(base.mode.names, followers[i], strict=True))
        start = np.array([followed.get(name, u[i, k]) for k, name in enumerate(forward.priors.names)])
        found.append(np.clip(start, -5.0, 5.0))
    return found


def following(
    w: FloatArray, jacobian: FloatArray, covariance: FloatArray, cost: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Log density [nats] (draws,) of draws of an effect's parameters that leave ``w`` (draws, entries) to the
    calibrated ones, which follow linearly; and where those then stand (draws, calibrated) in prior coordinates.

    jacobian: (entries, calibrated). covariance: (entries, entries). cost: the draws' own prior cost [nats] (draws,).
    """
    white = cho_solve(cho_factor(covariance + jacobian @ jacobian.T, lower=True), w.T)
    return -0.5 * np.sum(w.T * white, axis=0) - cost, (jacobian.T @ white).T


def scout_shifts(forward: Forward, base: HypothesisFit) -> tuple[FloatArray, FloatArray]:
    """How far each scouted size of what ``forward`` has beyond ``base`` moves the entries, (scouts, entries), and its
    prior cost (scouts,) in nats."""
    u, own = _scouts(forward, base)
    theta = forward.priors.from_normal(u)
    neutral = neutral_parameters(forward, theta[0], own)
    added = [name for name in forward.candidates if name not in base.effects]
    return effect_shifts(forward, theta, neutral, added), 0.5 * np.sum(u[:, own] ** 2, axis=1)


def _scouts(forward: Forward, base: HypothesisFit) -> tuple[FloatArray, list[int]]:
    """Points (scouts, params) in prior coordinates: the base mode with draws of the candidates' own
    parameters that it lacks; and which those are."""
    known = dict(zip(base.mode.names, base.mode.u, strict=True))
    default = forward.priors.to_normal(_default_values(forward))
    mode = np.array([known.get(p.name, default[i]) for i, p in enumerate(forward.parameters)])
    own = [i for i, p in enumerate(forward.parameters) if forward.own(p.name) and p.name not in known]
    if not own:
        return mode[None], own
    u = np.tile(mode, (SCOUTS, 1))
    # wider than the prior: effects larger than expected are scouted too
    points = qmc.Sobol(len(own), scramble=False).random(2 * SCOUTS)[1 : SCOUTS + 1]
    u[:, own] = SCOUT_WIDTH * ndtri(np.clip(points, 1e-6, 1 - 1e-6))
    return u, own
