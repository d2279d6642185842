"""From evidence to probabilities: prior odds, a temperature, both fixed on a development set.

Laplace evidence trusts its own assumptions to the last nat. Another form of the same law, or a base law that is
a little off, makes it overconfident; dividing log evidence by a temperature above one is the one-parameter
correction, and the development set says how much.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import expit, logsumexp

from eaclutch.diagnosis.counted import counted_evidence
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.physics.effects import BASE, CANDIDATES, LOOKALIKES
from eaclutch.records import FloatArray

NONE: tuple[str, ...] = ()
UNKNOWN: tuple[str, ...] = ("unknown",)
LIBRARY = len(CANDIDATES)  # candidates that the library names


def probabilities(
    results: Sequence[CandidateResult],
    thresholds: Mapping[str, Any],
    left: Mapping[tuple[str, ...], float] = MappingProxyType({}),
) -> dict[tuple[str, ...], float]:
    """Probability of each weighed set of effects; adds up to one.

    ``results`` hold the base model (no effects; its open evidence is that of ``unknown``) and every single and pair
    that was fitted. A named set may leave a nameless remainder, which costs it ``remainder_cost`` nats: its law is not
    the library's, but it is still the cause. An effect that the library lacks must do better than that by itself. A set
    that predicts left-out conditions worse than the base model, or a pair clearly worse than one of its two, may leave
    none: what makes a gap wider explains no part of it, however well it does elsewhere once a block is given up. Of the
    nats by which the best name beats the nameless terms only a part counts (``against_unknown``): these stand for all
    laws that nobody wrote down, and such a law may look more like a library effect than like them. Lookalikes, each
    less probable beforehand than an effect of the library (``lookalike_share``, ``odds``), are written down, and count
    in full; what they win is ``unknown``'s, and the name's beside which one was fitted. And a name whose fit fails the
    absolute check, or that leaves what a nameless remainder gains ``misfit_remainder`` nats by, gives ``misfit_share``
    of its probability to ``unknown``, for evidence only says who is best, and more (``partly``) where it surely leaves
    much of a large gap on conditions left out (``left``: how many times the base model's). So does one that surely
    widens that by far, or hardly narrows a large one (``widening``). The odds of ``unknown`` against all that may be
    named are corrected last (``unknown_odds``); no effect keeps its probability, but for what it gives to ``unknown``
    where repeats drift (``CandidateResult.repeat_drift``): what drifts is no scatter, and no effect of the library does
    that.
    """
    scores = _scores(results, thresholds)
    # a name that leaves what a lookalike explains is still the cause, as one that leaves a nameless remainder
    score = {
        effects: float(logsumexp([x, *scores.beside.get(effects, {}).values()]))
        for effects, x in scores.named.items()
    }
    nameless, best = scores.nameless, max((x for effects, x in score.items() if effects), default=-np.inf)
    if best > nameless:
        nameless = best - float(thresholds["against_unknown"]) * (best - nameless)
    score[UNKNOWN] = float(logsumexp([nameless, *scores.lookalikes.values()]))
    found = dict(
        zip(score, np.exp(list(score.values()) - logsumexp(list(score.values()))).tolist(), strict=True)
    )
    gap = next((r.gap_left_out for r in results if not r.effects), 0.0)
    for result in results:
        if not result.effects or result.effects not in found:
            continue
        kept = _kept(result, left.get(result.effects, 0.0), gap, thresholds)
        found[UNKNOWN] += (1.0 - kept) * found[result.effects]
        found[result.effects] *= kept
    drifting = _drifting(next((r for r in results if not r.effects), None), thresholds)
    found[UNKNOWN] += drifting * found[NONE]
    found[NONE] *= 1.0 - drifting
    return _corrected(found, float(thresholds["unknown_odds"]))


def _drifting(base: CandidateResult | None, thresholds: Mapping[str, Any]) -> float:
    """What no effect gives to ``unknown`` for repeats that drift: its share by the evidence of a drift and the prior
    odds of both; 0 without evidence for one."""
    if base is None or base.repeat_drift <= 0.0:
        return 0.0
    prior = thresholds["prior"]
    odds = base.repeat_drift / float(thresholds["temperature"]) + np.log(prior["unknown"] / prior["none"])
    return float(expit(odds))


def _kept(result: CandidateResult, left: float, gap: float, thresholds: Mapping[str, Any]) -> float:
    """Share of its probability that a name keeps from ``unknown``, for what it leaves: ``left`` times the base model's
    ``gap``."""
    partly, widening, kept = thresholds["partly"], thresholds["widening"], 1.0
    large = gap > thresholds["large_gap"]
    needs = result.log_evidence_open - result.log_evidence > thresholds["misfit_remainder"]
    if needs or result.adequate_p < thresholds["verdict"]["adequate_p_value"]:
        much = large and left > partly["times"]
        kept -= float(partly["share"] if much else thresholds["misfit_share"])
    if left > (widening["of_large"] if large else widening["times"]):
        kept *= 1.0 - float(widening["share"])
    return kept


def _corrected(found: dict[tuple[str, ...], float], odds: float) -> dict[tuple[str, ...], float]:
    """Probabilities with the odds of ``unknown`` against the named sets multiplied by ``odds``."""
    named = 1.0 - found[NONE] - found[UNKNOWN]
    if not named + found[UNKNOWN] > 0.0:
        return found
    scale = float(named_scale(named, found[UNKNOWN], odds))
    kept = {effects: weight * scale for effects, weight in found.items()}
    return kept | {NONE: found[NONE], UNKNOWN: odds * kept[UNKNOWN]}


def named_scale(named: ArrayLike, unknown: ArrayLike, odds: float) -> FloatArray:
    """Factor on the probability of each named set by which ``odds`` times those of ``unknown`` leave what
    both have together, ``named + unknown`` (above 0), as it is."""
    named, unknown = np.asarray(named), np.asarray(unknown)
    return np.asarray((named + unknown) / (named + odds * unknown))


def log_prior(effects: Sequence[str], names: Sequence[str], prior: Mapping[str, Any]) -> float:
    """Log of the prior probability of a set of ``effects``, up to a constant, where ``names`` may be named.

    Candidates are few and seldom: none, one, two of them. An effect of the base model, weighed where a campaign's model
    leaves it out, acts or does not whatever candidates do (``base_odds``)."""
    candidates = [name for name in effects if name not in BASE]
    # an effect is as likely beforehand whether few others are weighed or many
    count = max(LIBRARY, sum(name not in BASE for name in names))
    named = 1.0 - prior["none"] - prior["unknown"]
    share = (
        prior["none"],
        named * (1.0 - prior["pair_share"]) / count,
        named * prior["pair_share"] / (count * (count - 1) // 2),
    )[len(candidates)]
    odds = [prior["base_odds"] if name in BASE else prior["odds"].get(name, 1.0) for name in effects]
    return float(np.log(share) + np.sum(np.log(odds)))


def unknown_as(results: Sequence[CandidateResult], thresholds: Mapping[str, Any]) -> str:
    """The lookalike that says best what ``unknown`` would be, empty where the nameless terms do."""
    scores = _scores(results, thresholds)
    best = max(scores.lookalikes, key=lambda name: scores.lookalikes[name], default="")
    return best if best and scores.lookalikes[best] > scores.nameless else ""


def left_as(results: Sequence[CandidateResult], thresholds: Mapping[str, Any], effects: Sequence[str]) -> str:
    """The lookalike beside which the name ``effects`` (one effect) is more probable than by itself, the best of them;
    empty where none is."""
    scores = _scores(results, thresholds)
    beside = scores.beside.get(tuple(effects), {})
    best = max(beside, key=lambda name: beside[name], default="")
    return best if best and beside[best] > scores.named[tuple(effects)] else ""


@dataclass(frozen=True)
class _Scores:
    """Log of posterior odds, up to a constant: of each set that may be named (and of none), of the nameless terms, of
    each lookalike by itself, and of each name with a lookalike beside it, {name: {lookalike: score}}."""

    named: dict[tuple[str, ...], float]
    nameless: float
    lookalikes: dict[str, float]
    beside: dict[tuple[str, ...], dict[str, float]]


def _scores(results: Sequence[CandidateResult], thresholds: Mapping[str, Any]) -> _Scores:
    prior = thresholds["prior"]
    alike = {r.effects: sorted(set(r.effects) & set(LOOKALIKES)) for r in results}
    names = [r.effects[0] for r in results if len(r.effects) == 1 and not alike[r.effects]]
    counted, temperature = counted_evidence(results, thresholds), float(thresholds["temperature"])
    less = float(np.log(prior["lookalike_share"]))
    nameless = max(r.log_evidence_without_open for r in results) / temperature + float(
        np.log(prior["unknown"])
    )
    named: dict[tuple[str, ...], float] = {}
    lookalikes: dict[str, float] = {}
    beside: dict[tuple[str, ...], dict[str, float]] = {}
    for r in results:
        score = counted(r) / temperature + log_prior(r.effects, names, prior) + less * len(alike[r.effects])
        if not alike[r.effects]:
            named[r.effects] = score
        elif len(r.effects) == 1:
            lookalikes[r.effects[0]] = score
        else:
            name = tuple(effect for effect in r.effects if effect not in alike[r.effects])
            beside.setdefault(name, {})[alike[r.effects][0]] = score
    return _Scores(named, nameless, lookalikes, beside)


def by_effect(weights: Mapping[tuple[str, ...], float]) -> dict[str, float]:
    """Probability of each effect (and of ``unknown`` and ``none``): sum over the sets that hold it."""
    found: dict[str, float] = {"none": weights.get(NONE, 0.0)}
    for effects, weight in weights.items():
        for name in effects:
            found[name] = found.get(name, 0.0) + weight
    return found
