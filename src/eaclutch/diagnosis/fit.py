"""Joint fit of one hypothesis: calibrated parameters and the effect's own, on the whole data vector.

Evidence is Laplace's in the priors' standard normal coordinates, averaged over how large the tolerance and the
session spread of this campaign are (a small grid in the thresholds file), so that no hypothesis lives or dies
by one assumed size.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.evidence import marginal_evidence
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.gaussian import Linearised
from eaclutch.diagnosis.hypothesis import HypothesisFit, form_signature, own_signature
from eaclutch.diagnosis.mode import Mode, find_mode, mode_at
from eaclutch.diagnosis.nearby import nearby
from eaclutch.diagnosis.starts import other_zeros, starts
from eaclutch.physics.effects import EFFECTS
from eaclutch.physics.kernels.compiled import threads
from eaclutch.records import FloatArray

HOPS = 3  # times that a fit tries what lies farther on
WORTH_A_HOP = 1.0  # nats that this has to gain
ROUNDS = 2  # fits, each around a gap of the size that the one before found
LARGEST_CHANGE = np.log(3.0)  # of that size from which another round is worth it


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
    of the same data) are a start in the place of the base fit's, or of the defaults; of a fit from scratch at no wider
    tolerances than usual the only one. ``size``: multipliers (tolerance,
    session) that it begins with, where another fit has found how large the gap is. A fit of the model by itself tries
    other zeros of the load cell from where it ends, that of effects looks around there (``_farther``).
    """
    best: HypothesisFit | None = None
    widest = max(thresholds["multipliers"]["tolerance"]["values"])
    for _ in range(ROUNDS):

        def highest(
            begin: Sequence[FloatArray], best: HypothesisFit | None, size: tuple[float, float] = size
        ) -> HypothesisFit:
            covariance_at = _covariance(forward, kernels, thresholds, size)
            # most of it is simulation in compiled code, in which other threads go on
            with ThreadPoolExecutor(threads()) as pool:
                modes = list(
                    pool.map(lambda start: find_mode(forward, data.values, covariance_at, start), begin)
                )
            for mode in modes:
                best = _finish(forward, data, kernels, thresholds, mode, size, best) or best
            assert best is not None
            return best

        if best is not None and size[0] < best.size[0]:
            begin = [best.mode.u]  # laws hold better than was thought, and the place is known
        else:
            begin = starts(forward, data, kernels, size, base, beyond, seeds, widest)
        best = highest(begin, best)
        for _ in range(HOPS):
            begin = _farther(forward, data, best, alone=base is None)
            if not begin:
                break
            tried = highest(begin, best)
            gained, best = tried.peak - best.peak, tried
            if gained < WORTH_A_HOP:
                break
        # around a gap of some size the base laws hold no better than that; without one, maybe better than was thought
        if abs(np.log(best.multipliers[0] / size[0])) < LARGEST_CHANGE:
            break
        size = best.multipliers
    assert best is not None
    return best


def _farther(forward: Forward, data: DataVector, best: HypothesisFit, alone: bool) -> list[FloatArray]:
    """Starts (params,) beside a fit's end that no slope leads to: draws of its effects' parameters around it, or, of a
    fit without effects that stands ``alone``, other zeros of the load cell."""
    if forward.candidates:
        return nearby(forward, data, best)
    return other_zeros(forward, best.mode.u) if alone else []


def fit_from(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    named: Mapping[str, float],
    size: tuple[float, float],
) -> HypothesisFit:
    """The fit that begins at ``named`` parameters (the others at their defaults) and nowhere else, around a gap of
    ``size`` (multipliers of tolerance and session) first, and of the size that it finds."""
    fitted: HypothesisFit | None = None
    for _ in range(ROUNDS):
        theta = np.array([named.get(p.name, p.default) for p in forward.parameters])
        covariance_at = _covariance(forward, kernels, thresholds, size)
        mode = find_mode(forward, data.values, covariance_at, forward.priors.to_normal(theta))
        fitted = _finish(forward, data, kernels, thresholds, mode, size)
        if fitted is None or fitted.multipliers == size:
            break
        named, size = fitted.parameters, fitted.multipliers
    assert fitted is not None
    return fitted


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
    predicted = forward.predict(forward.priors.from_normal(u))[0]
    mode = mode_at(forward, u, predicted, None, converged)
    fitted = _finish(forward, data, kernels, thresholds, mode, size)
    assert fitted is not None
    return fitted


def _covariance(
    forward: Forward, kernels: Kernels, thresholds: Mapping[str, Any], size: tuple[float, float]
) -> Callable[[FloatArray], FloatArray]:
    """Covariance of the entries at parameters (params,), around a gap of ``size``."""
    tolerance, session = size

    def at(theta: FloatArray) -> FloatArray:
        if not forward.candidates:
            return kernels.total(tolerance=tolerance, session=session)
        return kernels.total(
            tolerance=tolerance, session=session,
            signature=form_signature(forward, theta), signature_tolerance=thresholds["signature_tolerance"],
        )  # fmt: skip

    return at


def _finish(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    mode: Mode,
    size: tuple[float, float],
    best: HypothesisFit | None = None,
) -> HypothesisFit | None:
    """The fit that ended at ``mode``, None where it is no higher than the ``best`` so far."""
    signature = own_signature(forward, mode.theta)
    form = (
        form_signature(forward, mode.theta)
        if any(EFFECTS[e].exact for e in forward.candidates)
        else signature
    )
    residual = data.values - mode.predicted
    found = marginal_evidence(forward, data, kernels, thresholds, mode, form, best.peak if best else None)
    if found is None:
        return None
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
