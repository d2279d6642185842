"""The nameless competitor: some smooth discrepancy, in some of the blocks, that no law in the library explains.

It is the tolerance of the base model blown up by a factor that each block chooses for itself. It pays for its
freedom by its evidence, like everybody else, and it is what a named effect must beat.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import logsumexp

from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.gaussian import Linearised, log_normal
from eaclutch.records import FloatArray

SESSION = "session spread"


@dataclass(frozen=True)
class Nameless:
    """log_evidence (nats); factors: how much each block's tolerance (and the session spread) was blown up;
    discrepancy (entries,): the smooth term itself, as the data put it."""

    log_evidence: float
    factors: dict[str, float]
    linearised: Linearised
    discrepancy: FloatArray


def nameless_fit(
    base: Linearised,
    data: DataVector,
    kernels: Kernels,
    thresholds: Mapping[str, Any],
    signature: FloatArray | None = None,
) -> Nameless:
    """Evidence of the nameless competitor around a fit's linearisation.

    ``signature``: of the effects in that fit, where it is not the base model's: the evidence is then that of the
    effects with a nameless remainder.

    The factors are chosen block by block, ``sweeps`` times at most; the sum over each one's grid, the others
    fixed, stands for the sum over all of them (they hardly interact).
    """
    settings, share = thresholds["nameless"], float(thresholds["signature_tolerance"])
    grid = np.array(settings["factors"], dtype=float)
    free = float(settings["free_share"])
    log_prior = np.log(np.where(grid == 1.0, 1.0 - free, free / max(1, int((grid > 1.0).sum()))))
    names = [*dict.fromkeys(data.block.tolist()), SESSION]
    prior = base.jacobian @ base.jacobian.T

    def score(factors: dict[str, float]) -> float:
        covariance = _covariance(factors, data, kernels, signature, share)
        chosen = sum(log_prior[int(np.flatnonzero(grid == f)[0])] for f in factors.values())
        return log_normal(base.w, covariance + prior) + float(chosen)

    factors = dict.fromkeys(names, 1.0)
    table: dict[str, FloatArray] = {}
    for _ in range(int(settings["sweeps"])):
        before = dict(factors)
        for name in names:
            table[name] = np.array([score({**factors, name: float(f)}) for f in grid])
            factors[name] = float(grid[int(np.argmax(table[name]))])
        if factors == before:
            break
    if any(factor != 1.0 for factor in factors.values()):
        evidence = score(factors) + sum(float(logsumexp(table[name] - np.max(table[name]))) for name in names)
    else:
        # nothing asks for more freedom; what stands for this hypothesis is one block that takes it all the same
        evidence = float(logsumexp([table[name][grid > 1.0] for name in names]))
    covariance = _covariance(factors, data, kernels, signature, share)
    linearised = Linearised(base.w, base.jacobian, covariance)
    own = np.array([factors[block] for block in data.block])
    smooth = kernels.tolerance * np.outer(own, own)
    return Nameless(evidence, factors, linearised, smooth @ np.linalg.solve(linearised.marginal(), base.w))


def _covariance(
    factors: Mapping[str, float],
    data: DataVector,
    kernels: Kernels,
    signature: FloatArray | None,
    share: float,
) -> FloatArray:
    tolerance = np.array([factors[block] for block in data.block])
    return kernels.total(
        tolerance=tolerance, session=factors[SESSION], signature=signature, signature_tolerance=share
    )
