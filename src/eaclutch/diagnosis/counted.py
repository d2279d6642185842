"""What of the evidence of a hypothesis counts beside the others: a nameless remainder, how far it narrows a gap, and
how much one condition alone may say for a further effect."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from eaclutch.diagnosis.free_swing import OSCILLATOR
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.physics.effects import BASE


def counted_evidence(
    results: Sequence[CandidateResult], thresholds: Mapping[str, Any]
) -> Callable[[CandidateResult], float]:
    """What of a result's evidence [nats] counts beside ``results`` (as they are when it is asked), as ``probabilities``
    compares them: with a nameless remainder where one is allowed, and of the base model where it was fitted best.

    Around a gap that no fit closes within the usual tolerances a remainder takes up what a name leaves, nearly
    whatever that is, and evidences rest on where fits ended. What a name does for conditions left out counts there
    as well: ``narrowing_weight`` nats for each e-fold of the gap left out, over the name that would lead without.

    At the usual tolerances one odd condition may be all that a second effect explains: of what a set gains over the
    best of the smaller sets in it, the condition that says most for it counts with ``one_condition`` nats at most."""
    cost = float(thresholds["remainder_cost"])
    slack = 1.0 + float(thresholds["pair_widening"])
    most = float(thresholds["one_condition"])
    usual, weight = (
        max(thresholds["multipliers"]["tolerance"]["values"]),
        float(thresholds["narrowing_weight"]),
    )

    def plain(result: CandidateResult) -> float:
        if not result.effects:
            return max(r.log_evidence_without for r in results)
        # the gap holds no swings: what narrows without the oscillator says nothing against it
        smaller = [r for r in results if set(r.effects) < set(result.effects)
                   and OSCILLATOR not in set(result.effects) - set(r.effects)]  # fmt: skip
        if any(r.gap_left_out * (slack if r.effects else 1.0) < result.gap_left_out for r in smaller):
            return result.log_evidence
        return float(np.logaddexp(result.log_evidence, result.log_evidence_open - cost))

    def odd(result: CandidateResult) -> float:
        """What one condition says too much for each effect more."""
        fewer = [r for r in results if r.effects and set(r.effects) < set(result.effects)]
        if not fewer:
            return 0.0
        best = max(fewer, key=plain)
        if set(result.effects) - set(best.effects) <= set(BASE):  # that acts, whatever else does
            return odd(best)
        said = np.subtract(result.log_density, best.log_density)
        return odd(best) + float(np.max(said - most, initial=0.0))

    def counted(result: CandidateResult) -> float:
        if not (result.effects and result.multipliers[0] > usual and result.gap_left_out > 0):
            return plain(result) - odd(result)
        lead = max((r for r in results if r.effects and r.gap_left_out > 0), key=plain, default=result)
        return plain(result) + weight * float(np.log(lead.gap_left_out / result.gap_left_out))

    return counted
