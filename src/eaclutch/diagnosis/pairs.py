"""Pairs of effects: screened by their signatures, fitted only where two may explain more than one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from eaclutch.diagnosis.fit import HypothesisFit, scout_shifts
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.weigh import counted_evidence

Counted = Callable[[CandidateResult], float]

WORTH_A_PAIR = 4.0  # nats that the best single effect must gain
WORTH_AGAIN = 3.0  # nats that a pair gains over one of its effects
LEADERS = 4  # singles that a second effect is tried on top of


def with_pairs(study: Study, found: Sequence[CandidateResult], limit: int) -> list[CandidateResult]:
    """``found`` with the most promising pairs. The leading singles are fitted once more from where others stand, and
    each single from where a pair that does better stands: what an effect gains must not be that another fit stopped
    short. Around a large gap, where fits end far apart, what leads is also fitted afresh."""
    results = list(found)
    counted = counted_evidence(results, study.thresholds)
    for i in _leaders(results, counted):
        others = [r for r in results if len(r.effects) == 1 and r is not results[i]]
        tried = [_again(study, results[i], max(others, key=counted))] if others else []
        results[i] = max([results[i], *tried, *_afresh(study, results[i])], key=counted)
    pairs = [max([pair, *_afresh(study, pair)], key=counted) for pair in weigh_pairs(study, results, limit)]
    for i, single in enumerate(results):
        above = [pair for pair in pairs if single.effects and set(single.effects) < set(pair.effects)]
        best = max(above, key=counted, default=single)
        if counted(best) > counted(single) + WORTH_AGAIN:
            results[i] = max(single, _again(study, single, best), key=counted)
    return results + pairs


def _leaders(results: Sequence[CandidateResult], counted: Counted) -> list[int]:
    """Places of the best singles that gain something over the base model."""
    plain = max((r.log_evidence for r in results if not r.effects), default=np.inf)
    worth = [i for i, r in enumerate(results) if len(r.effects) == 1 and counted(r) > plain + WORTH_A_PAIR]
    return sorted(worth, key=lambda i: -counted(results[i]))[:LEADERS]


def _again(study: Study, single: CandidateResult, other: CandidateResult) -> CandidateResult:
    """The same fit from the calibrated parameters of another."""
    return study.weigh(single.effects, _seeds([single]) | _seeds([other]))


def _afresh(study: Study, result: CandidateResult) -> list[CandidateResult]:
    """The same fit from scratch, where it needed wider tolerances than usual; nothing elsewhere."""
    if result.multipliers[0] <= max(study.thresholds["multipliers"]["tolerance"]["values"]):
        return []
    return [study.weigh(result.effects, afresh=True)]


def weigh_pairs(study: Study, singles: Sequence[CandidateResult], limit: int) -> list[CandidateResult]:
    """Fit the ``limit`` most promising pairs, each also from the fit of the one effect with the other on top."""
    counted = counted_evidence(singles, study.thresholds)
    named = sorted((r for r in singles if len(r.effects) == 1), key=counted, reverse=True)
    plain = max((r.log_evidence for r in singles if not r.effects), default=-np.inf)
    # without a gap that one effect narrows there is nothing for a second one to do
    if limit <= 0 or len(named) < 2 or counted(named[0]) < plain + WORTH_A_PAIR:
        return []
    promises: dict[tuple[str, str], tuple[float, HypothesisFit]] = {}
    for leader in named[:LEADERS]:
        fitted = study.fit(leader.effects, _seeds([leader]))
        for name, gain in _gains(study, fitted).items():
            first, second = sorted((leader.effects[0], name))
            promise = leader.log_evidence + gain
            if promise > promises.get((first, second), (-np.inf, fitted))[0]:
                promises[first, second] = promise, fitted
    best = sorted(promises, key=lambda pair: -promises[pair][0])[:limit]
    alone = {r.effects[0]: r for r in named}
    return [
        study.weigh(pair, _seeds([alone[name] for name in pair if name in alone]), promises[pair][1])
        for pair in best
    ]


def _gains(study: Study, leader: HypothesisFit) -> dict[str, float]:
    """Nats that each further effect promises beside a fitted one: what the best of its scouted sizes takes off the
    misfit when all parameters of the leader follow linearly, less what it costs in prior."""
    tolerance, session = leader.multipliers
    # a gap that one effect leaves is for the second one, not for wide tolerances
    usual = max(study.thresholds["multipliers"]["tolerance"]["values"])
    covariance = study.kernels.total(
        tolerance=min(tolerance, usual), session=session,
        signature=leader.signature, signature_tolerance=study.thresholds["signature_tolerance"],
    )  # fmt: skip
    linearised = replace(leader.linearised, covariance=covariance)
    factor, w = cho_factor(linearised.marginal(), lower=True), linearised.w
    start = float(w @ cho_solve(factor, w))
    found = {}
    for name in study.candidates:
        if name not in leader.effects:
            shift, cost = scout_shifts(study.forward((*leader.effects, name)), leader)
            trial = w - shift
            gain = 0.5 * (start - np.sum(trial.T * cho_solve(factor, trial.T), axis=0)) - cost
            found[name] = float(np.max(gain))
    return found


def _seeds(singles: Sequence[CandidateResult]) -> dict[str, float]:
    """Where two effects' own fits stand: the stronger one's calibrated parameters, both ones' own."""
    strongest = max(singles, key=lambda r: r.log_evidence)
    seeds = {name: float(entry["mean"]) for name, entry in strongest.calibrated.items()}
    for single in singles:
        for name, entry in single.parameters.items():
            seeds[name if "." in name else f"{single.effects[0]}.{name}"] = float(entry["mean"])
    return seeds
