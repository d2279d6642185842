"""Pairs of effects: screened by their signatures, fitted only where two may explain more than one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from eaclutch.diagnosis.fit import scout_shifts
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.study import Study

LEADERS = 3  # singles that a second effect is tried on top of


def weigh_pairs(study: Study, singles: Sequence[CandidateResult], limit: int) -> list[CandidateResult]:
    """Fit the ``limit`` most promising pairs.

    Promise: what a second effect, at the best of its scouted sizes, takes off the leaders' misfit when the
    calibrated parameters follow linearly, less what it costs in prior.
    """
    named = sorted((r for r in singles if len(r.effects) == 1), key=lambda r: -r.log_evidence)
    if limit <= 0 or len(named) < 2:
        return []
    shifts = {name: scout_shifts(study.forward((name,)), study.base) for name in study.candidates}
    factor = cho_factor(study.base.linearised.marginal(), lower=True)
    scores: dict[tuple[str, str], float] = {}
    for leader in named[:LEADERS]:
        w = study.base.linearised.w - np.array(leader.shift)
        start = float(w @ cho_solve(factor, w))
        for name in study.candidates:
            if name == leader.effects[0]:
                continue
            shift, cost = shifts[name]
            trial = w - shift
            gain = 0.5 * (start - np.sum(trial.T * cho_solve(factor, trial.T), axis=0)) - cost
            first, second = sorted((leader.effects[0], name))
            pair = (first, second)
            scores[pair] = max(scores.get(pair, -np.inf), leader.log_evidence + float(np.max(gain)))
    best = sorted(scores, key=lambda pair: -scores[pair])[:limit]
    return [study.weigh(pair) for pair in best]
