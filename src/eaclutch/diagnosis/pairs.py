"""Pairs of effects: screened by their signatures, fitted only where two may explain more than one. A leading pair's
effects are each weighed beside lookalikes, too. Sets of three are weighed only where a base effect that the model
leaves out stands beside the pair that leads."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np

from eaclutch.diagnosis.counted import counted_evidence
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.promises import promises
from eaclutch.diagnosis.refits import (
    Counted,
    Fit,
    afresh,
    again,
    is_wide,
    keep_better,
    seeds_of,
    weigh_fit,
    worth_again,
)
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.spread import Spread
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.weigh import probabilities
from eaclutch.physics.effects import BASE

WORTH_A_PAIR = 4.0  # nats that the best single effect must gain
WORTH_AGAIN = 3.0  # nats that a pair gains over one of its effects
WORTH_A_LOOK = 1.0  # nats that a lookalike promises where no effect gains anything
NEAR = 40.0  # nats behind what leads beyond which no lookalike is fitted once more
LEADERS = 4  # singles that a second effect is tried on top of, and lookalikes that are fitted once more
FOREMOST = 3  # of these, some of whose pairs are weighed whatever slopes promise
BESIDE = 3  # lookalikes that are fitted beside one of a pair's effects


def with_pairs(
    study: Study, found: Sequence[CandidateResult], limit: int, jobs: int = 1
) -> list[CandidateResult]:
    """``found`` with the most promising pairs and with the library's lookalikes, worked out in ``jobs`` processes. The
    leading singles are fitted once more from where others stand, and singles from where a pair that does better stands
    (``worth_again`` says which): what an effect gains must not be that another fit stopped short. Around a large gap,
    where fits end far apart, what leads is also fitted afresh."""
    results = list(found)
    counted = counted_evidence(results, study.thresholds)
    with Spread(study, jobs) as spread:
        leaders = _leaders(results, counted)
        keep_better(spread, results, _from_others(study, results, leaders, counted), counted)
        keep_better(spread, results, afresh(study, [results[i] for i in leaders]), counted)
        pairs = weigh_pairs(spread, results, limit)
        keep_better(spread, pairs, afresh(study, pairs), counted)
        further = []
        for single in worth_again(study, results, results + pairs, counted):
            above = [pair for pair in pairs if single.effects and set(single.effects) < set(pair.effects)]
            best = max(above, key=counted, default=single)
            if counted(best) > counted(single) + WORTH_AGAIN:
                further.append(again(single, best))
        keep_better(spread, results, further, counted)
        lookalikes = _weigh_lookalikes(spread, results + pairs, counted, all_of_them=bool(leaders))
        beside = _lookalikes_beside(spread, results + pairs, lookalikes)
        keep_better(spread, beside, afresh(study, beside), counted)
        thirds = spread(_third, _beside_the_lead(study, results + pairs))
        keep_better(spread, thirds, afresh(study, thirds), counted)
    return results + pairs + lookalikes + beside + thirds


def _leaders(results: Sequence[CandidateResult], counted: Counted) -> list[int]:
    """Places of the best singles that gain something over the base model."""
    plain = max((r.log_evidence for r in results if not r.effects), default=np.inf)
    worth = [i for i, r in enumerate(results) if len(r.effects) == 1 and counted(r) > plain + WORTH_A_PAIR]
    return sorted(worth, key=lambda i: -counted(results[i]))[:LEADERS]


def _from_others(
    study: Study, results: Sequence[CandidateResult], leaders: Sequence[int], counted: Counted
) -> list[Fit]:
    """Each leader's fit from the calibrated parameters of the best single beside it."""
    singles = [r for r in results if len(r.effects) == 1]
    if len(singles) < 2:
        return []
    leading = worth_again(study, [results[i] for i in leaders], singles, counted)
    return [again(one, max((r for r in singles if r is not one), key=counted)) for one in leading]


def weigh_pairs(spread: Spread, singles: Sequence[CandidateResult], limit: int) -> list[CandidateResult]:
    """Fit the ``limit`` most promising pairs, each also from the fit of the one effect with the other on top.

    Around a gap that no single effect narrows slopes promise badly: the pairs of the foremost singles are fitted, too.
    So are those of the foremost with each base effect that the model leaves out.
    """
    counted = counted_evidence(singles, spread.study.thresholds)
    named = sorted((r for r in singles if len(r.effects) == 1), key=counted, reverse=True)
    plain = max((r.log_evidence for r in singles if not r.effects), default=-np.inf)
    # without a gap that one effect narrows there is nothing for a second one to do
    if limit <= 0 or len(named) < 2 or counted(named[0]) < plain + WORTH_A_PAIR:
        return []
    promised: dict[tuple[str, str], tuple[float, HypothesisFit]] = {}
    leaders = named[:LEADERS]
    asked = [(leader, spread.study.candidates) for leader in leaders]
    for leader, (fitted, gains) in zip(leaders, spread(_promises, asked), strict=True):
        for name, gain in gains.items():
            first, second = sorted((leader.effects[0], name))
            promise = leader.log_evidence + gain
            if promise > promised.get((first, second), (-np.inf, fitted))[0]:
                promised[first, second] = promise, fitted
    best = sorted(promised, key=lambda pair: -promised[pair][0])[:limit]
    foremost = [leader.effects[0] for leader in leaders[:FOREMOST]]
    if is_wide(spread.study, leaders[0]):
        best += combinations(sorted(foremost), 2)
    # what the model was told to leave out acts, if it does, beside whatever leads
    known = [name for name in spread.study.candidates if name in BASE]
    best += [min((a, b), (b, a)) for a, b in product(foremost, known) if a != b]
    alone = {r.effects[0]: r for r in named}
    fits = [
        Fit(pair, seeds_of([alone[name] for name in pair if name in alone]), promised[pair][1])
        for pair in dict.fromkeys(best)
    ]
    return spread(weigh_fit, fits)


def _weigh_lookalikes(
    spread: Spread, results: Sequence[CandidateResult], counted: Counted, *, all_of_them: bool
) -> list[CandidateResult]:
    """Those that a name must hold against; where there is nothing to name, those that promise more than no effect. The
    foremost are fitted once more from where the best of ``results`` stands, as leading singles are."""
    study, names = spread.study, spread.study.lookalikes
    if not all_of_them:
        gains = promises(study, study.base, names)
        names = tuple(name for name in names if gains[name] > WORTH_A_LOOK)
    lookalikes = spread(weigh_fit, [Fit((name,)) for name in names])
    everything = [*results, *lookalikes]
    lead, best = max(map(counted, everything)), max(results, key=counted)
    near = sorted((r for r in lookalikes if counted(r) > lead - NEAR), key=counted, reverse=True)
    foremost = worth_again(study, near[:LEADERS], everything, counted)
    # from the base model's fit they have been fitted already
    keep_better(spread, lookalikes, [again(r, best) for r in foremost if best.effects], counted)
    keep_better(spread, lookalikes, afresh(study, near), counted)
    return lookalikes


def _lookalikes_beside(
    spread: Spread, results: Sequence[CandidateResult], lookalikes: Sequence[CandidateResult]
) -> list[CandidateResult]:
    """What a leading pair's second effect must hold against: those lookalikes that promise most beside the other one,
    fitted there."""
    study = spread.study
    weights = probabilities([*results, *lookalikes], study.thresholds)
    pairs = [r for r in results if len(r.effects) == 2]
    lead = max(pairs, key=lambda r: weights[r.effects], default=None)
    if lead is None or weights[lead.effects] < study.thresholds["verdict"]["smallest_alternative"]:
        return []
    alone = {r.effects[0]: r for r in [*results, *lookalikes] if len(r.effects) == 1}
    firsts = [alone[name] for name in lead.effects if name in alone]
    asked = [(first, study.lookalikes) for first in firsts]
    promised = {
        (first.effects[0], name): (first.log_evidence + gain, fitted)
        for first, (fitted, gains) in zip(firsts, spread(_promises, asked), strict=True)
        for name, gain in gains.items()
    }
    best = sorted(promised, key=lambda both: -promised[both][0])[:BESIDE]
    fits = [
        Fit(tuple(sorted(both)), seeds_of([alone[name] for name in both if name in alone]), promised[both][1])
        for both in best
    ]
    return spread(weigh_fit, fits)


def _beside_the_lead(study: Study, results: Sequence[CandidateResult]) -> list[tuple[CandidateResult, ...]]:
    """Where a pair of candidates leads: the pair and, one at a time, the base effects that the model leaves out."""
    weights = probabilities(results, study.thresholds)
    lead = max((r for r in results if r.effects), key=lambda r: weights[r.effects], default=None)
    if lead is None or len(lead.effects) < 2 or set(lead.effects) & set(BASE):
        return []
    return [(lead, r) for r in results if len(r.effects) == 1 and r.effects[0] in BASE]


def _third(study: Study, members: tuple[CandidateResult, ...]) -> CandidateResult:
    """A pair with one more effect, from the fit of the pair."""
    pair, single = members
    fitted = study.fit(pair.effects, seeds_of([pair]))
    return study.weigh(tuple(sorted((*pair.effects, *single.effects))), seeds_of(members), fitted)


def _promises(
    study: Study, asked: tuple[CandidateResult, Sequence[str]]
) -> tuple[HypothesisFit, dict[str, float]]:
    """A leader's fit, and what each of the further effects asked for promises on top of it."""
    leader, names = asked
    fitted = study.fit(leader.effects, seeds_of([leader]))
    return fitted, promises(study, fitted, names)
