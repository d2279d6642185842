"""Pairs of effects: screened by their signatures, fitted only where two may explain more than one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from eaclutch.diagnosis.fit import scout_shifts
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.study import Study

WORTH_A_PAIR = 4.0  # nats that the best single effect must gain
WORTH_AGAIN = 3.0  # nats that a pair gains over one of its effects
LEADERS = 3  # singles that a second effect is tried on top of


def with_pairs(study: Study, found: Sequence[CandidateResult], limit: int) -> list[CandidateResult]:
    """``found`` with the most promising pairs. The leading singles are fitted once more from where others stand, and
    each single from where a pair that does better stands: what an effect gains must not be that another fit stopped
    short."""
    results = list(found)
    for i in _leaders(results):
        others = [r for r in results if len(r.effects) == 1 and r is not results[i]]
        if others:
            results[i] = _again(study, results[i], max(others, key=lambda r: r.log_evidence))
    pairs = weigh_pairs(study, results, limit)
    for i, single in enumerate(results):
        above = [pair for pair in pairs if single.effects and set(single.effects) < set(pair.effects)]
        best = max(above, key=lambda pair: pair.log_evidence, default=single)
        if best.log_evidence > single.log_evidence + WORTH_AGAIN:
            results[i] = _again(study, single, best)
    return results + pairs


def _leaders(results: Sequence[CandidateResult]) -> list[int]:
    """Places of the best singles that gain something over the base model."""
    plain = max((r.log_evidence for r in results if not r.effects), default=np.inf)
    worth = [
        i for i, r in enumerate(results) if len(r.effects) == 1 and r.log_evidence > plain + WORTH_A_PAIR
    ]
    return sorted(worth, key=lambda i: -results[i].log_evidence)[:LEADERS]


def _again(study: Study, single: CandidateResult, other: CandidateResult) -> CandidateResult:
    """The better of a fit and the same from the calibrated parameters of another."""
    again = study.weigh(single.effects, _seeds([single]) | _seeds([other]))
    return max(single, again, key=lambda result: result.log_evidence)


def weigh_pairs(study: Study, singles: Sequence[CandidateResult], limit: int) -> list[CandidateResult]:
    """Fit the ``limit`` most promising pairs.

    Promise: what a second effect, at the best of its scouted sizes, takes off the leaders' misfit when the
    calibrated parameters follow linearly, less what it costs in prior.
    """
    named = sorted((r for r in singles if len(r.effects) == 1), key=lambda r: -r.log_evidence)
    alone_best = named[0].log_evidence if named else -np.inf
    plain = max((r.log_evidence for r in singles if not r.effects), default=-np.inf)
    # without a gap that one effect narrows there is nothing for a second one to do
    if limit <= 0 or len(named) < 2 or alone_best < plain + WORTH_A_PAIR:
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
    alone = {r.effects[0]: r for r in named}
    return [study.weigh(pair, _seeds([alone[name] for name in pair if name in alone])) for pair in best]


def _seeds(singles: Sequence[CandidateResult]) -> dict[str, float]:
    """Where two effects' own fits stand: the stronger one's calibrated parameters, both ones' own."""
    strongest = max(singles, key=lambda r: r.log_evidence)
    seeds = {name: float(entry["mean"]) for name, entry in strongest.calibrated.items()}
    for single in singles:
        for name, entry in single.parameters.items():
            seeds[name if "." in name else f"{single.effects[0]}.{name}"] = float(entry["mean"])
    return seeds
