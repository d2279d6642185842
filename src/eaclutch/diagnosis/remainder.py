"""What is left beside a fit, without a name: smooth terms block by block, or a law of one quantity over one setting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.evidence import NEGLIGIBLE, unrealised
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.gaussian import Linearised, log_normal
from eaclutch.diagnosis.hypothesis import HypothesisFit, form_signature
from eaclutch.diagnosis.mode import Mode, find_mode
from eaclutch.diagnosis.modulated import modulated_fit
from eaclutch.diagnosis.nameless import Nameless, nameless_fit
from eaclutch.records import FloatArray

WORTH_A_REFIT = 3.0  # nats that a linearised fit promises and does not keep
ROUNDS = 4  # of smooth terms and fits beside each other, around a large gap
WORTH_A_ROUND = 0.5  # nats that a round has to gain
PLACES = 3  # where a law is looked for: at the fit, then where the law itself puts it


@dataclass(frozen=True)
class Remainder:
    """log_evidence (nats) of a fit with a nameless remainder; discrepancy (entries,): the remainder itself, as the data
    put it; law: (quantity, setting) where a changing quantity says it best, else empty."""

    log_evidence: float
    discrepancy: FloatArray
    law: tuple[str, ...] = ()


def with_remainder(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    fitted: HypothesisFit,
    nameless: Nameless | None = None,
) -> Remainder:
    """Evidence of ``fitted`` with a remainder, averaged over the two kinds; ``nameless``: its smooth terms where they
    are known already."""
    if nameless is None:
        nameless = nameless_fit(fitted.linearised, data, kernels, thresholds, fitted.form)
    share = float(thresholds["modulated"]["share"])
    here = _Place(fitted.mode, fitted.linearised.w, fitted.linearised.jacobian)
    smooth, there = _kept(forward, data, here, nameless.linearised, nameless.log_evidence)
    if fitted.multipliers[0] > max(thresholds["multipliers"]["tolerance"]["values"]):
        smooth, nameless = _settled(forward, data, kernels, thresholds, smooth, nameless, there)
    smooth += np.log1p(-share)
    found, laws = Remainder(float(smooth), nameless.discrepancy), -np.inf
    covariance = kernels.total(
        signature=fitted.form, signature_tolerance=float(thresholds["signature_tolerance"])
    )
    for _ in range(PLACES):
        linearised = Linearised(here.w, here.jacobian, covariance)
        law = modulated_fit(linearised, here.mode, data, thresholds)
        if law is None or law.log_evidence + np.log(share) < smooth - NEGLIGIBLE:
            break
        kept, there = _kept(forward, data, here, law.linearised, law.log_evidence)
        laws = max(laws, kept + np.log(share))
        if laws > found.log_evidence:
            found = Remainder(kept + np.log(share), law.discrepancy, (law.quantity, law.setting))
        if there is here:
            break
        here = there
    return replace(found, log_evidence=float(np.logaddexp(smooth, laws)))


@dataclass(frozen=True)
class _Place:
    """Where a model is linearised: ``w`` (entries,) and ``jacobian`` (entries, params) there."""

    mode: Mode
    w: FloatArray
    jacobian: FloatArray

    @classmethod
    def fitted(cls, forward: Forward, data: DataVector, covariance: FloatArray, u: FloatArray) -> _Place:
        """Where a fit from ``u`` (params,) with that covariance ends."""
        mode = find_mode(forward, data.values, lambda theta: covariance, u)
        return cls(mode, data.values - mode.predicted + mode.jacobian @ mode.u, mode.jacobian)


def _settled(
    forward: Forward,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    evidence: float,
    nameless: Nameless,
    place: _Place,
) -> tuple[float, Nameless]:
    """Around a large gap: smooth terms and the fit beside them, each found anew beside the other until that gains
    nothing, or ``ROUNDS`` times. Fits at wide tolerances end far apart there; what a remainder says of them would
    depend on where."""
    for _ in range(ROUNDS):
        covariance = nameless.linearised.covariance
        place = _Place.fitted(forward, data, covariance, place.mode.u)
        form = form_signature(forward, place.mode.theta)
        linearised = Linearised(place.w, place.jacobian, covariance)
        again = nameless_fit(linearised, data, kernels, thresholds, form)
        kept = again.log_evidence - unrealised(forward, data, place.mode, again.linearised)
        if kept < evidence + WORTH_A_ROUND:
            break
        evidence, nameless = kept, again
    return evidence, nameless


def _kept(
    forward: Forward, data: DataVector, place: _Place, linearised: Linearised, promised: float
) -> tuple[float, _Place]:
    """Evidence as the model keeps it, and where: a linearised fit that promises much more is fitted once more with the
    remainder's covariance, for it stands where the gap without a remainder had pulled it."""
    lost = unrealised(forward, data, place.mode, linearised)
    if lost < WORTH_A_REFIT:
        return promised - lost, place
    there = _Place.fitted(forward, data, linearised.covariance, place.mode.u)
    again = Linearised(there.w, there.jacobian, linearised.covariance)
    gain = log_normal(there.w, again.marginal()) - log_normal(linearised.w, linearised.marginal())
    kept = promised + max(gain - unrealised(forward, data, there.mode, again), -lost)
    return kept, there
