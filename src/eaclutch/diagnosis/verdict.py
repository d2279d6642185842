"""From probabilities to words: none, a name, a set that cannot be told apart, or unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.weigh import NONE, UNKNOWN, left_as, unknown_as
from eaclutch.physics.effects import BASE, EFFECTS

Effects = tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """effects: (), ("unknown",), one name or two; alternatives: sets that cannot be ruled out against it; like: the
    lookalike that says best what ``unknown`` would be, or empty."""

    effects: Effects
    probability: float
    alternatives: tuple[Effects, ...]
    why: str
    like: str


def decide(
    weights: Mapping[Effects, float],
    results: Sequence[CandidateResult],
    thresholds: Mapping[str, Any],
    notes: Sequence[str] = (),
) -> Verdict:
    """The most probable set, with as many further sets as it takes to hold the truth nearly always.

    A verdict names two effects at most (``leading``). Where a third one, which the model was told to leave out, is
    weighed beside a pair, the three are among the alternatives."""
    rules = thresholds["verdict"]
    first, probability = leading(weights)
    held = weights[first]
    alternatives: list[Effects] = []
    for effects in sorted((e for e in weights if e != first), key=lambda effects: -weights[effects]):
        if held >= rules["set_coverage"] or len(alternatives) + 1 >= rules["set_members"]:
            break
        if weights[effects] < rules["smallest_alternative"]:
            break
        alternatives.append(effects)
        held += weights[effects]
    fitted = {r.effects: r for r in results}
    like = unknown_as(results, thresholds)
    more = [
        f"{weights[three]:.2f} of it with {in_words(tuple(e for e in three if e not in first))} beside them"
        for three in built_on(first, weights)
        if weights[three] >= rules["smallest_alternative"]
    ]
    words = ", ".join([f"{probability:.2f}", *more])
    left = left_as(results, thresholds, first)
    sentence = _sentence(first, words, alternatives, fitted, rules, notes, like, left)
    return Verdict(first, probability, tuple(alternatives), sentence, like)


def leading(weights: Mapping[Effects, float]) -> tuple[Effects, float]:
    """The set that a verdict names, two effects at most, and its probability: a pair's with that of the sets of three
    that are built on it."""
    said = {
        effects: weight + sum(weights[three] for three in built_on(effects, weights))
        for effects, weight in weights.items()
        if len(effects) <= 2
    }
    first = max(said, key=lambda effects: said[effects])
    return first, said[first]


def built_on(pair: Effects, weights: Mapping[Effects, float]) -> list[Effects]:
    """The sets of three that are a pair of candidates and one base effect that the model leaves out."""
    return [effects for effects in weights if len(effects) > 2 and set(effects) - set(BASE) == set(pair)]


def _sentence(
    first: Effects,
    probability: str,
    alternatives: Sequence[Effects],
    fitted: Mapping[Effects, CandidateResult],
    rules: Mapping[str, Any],
    notes: Sequence[str],
    like: str,
    left: str,
) -> str:
    if first == NONE:
        text = "no gap beyond repeatability, session spread and the base laws' tolerance"
    elif first == UNKNOWN:
        text = _unknown(fitted.get(NONE), like)
    else:
        text = f"{in_words(first)} explains the gap best, the calibrated parameters refitted along with it"
    text += f" (probability {probability})"
    if first not in (NONE, UNKNOWN) and fitted[first].adequate_p < rules["adequate_p_value"]:
        text += f"; a part remains that it does not explain (p = {fitted[first].adequate_p:.2g} that noise makes it)"
    if left:
        text += f"; what it leaves looks most like {EFFECTS[left].summary}"
    if alternatives:
        text += "; cannot be ruled out: " + ", ".join(in_words(a) for a in alternatives)
        if like and UNKNOWN in alternatives:
            text += f" (such as {EFFECTS[like].summary})"
    if like and first == UNKNOWN:
        text += f"; model.effects with {like} shows what is left beside it"
    return text + (". Caveats: " + "; ".join(notes) if notes else "")


def _unknown(base: CandidateResult | None, like: str) -> str:
    if like:
        return f"there is a gap that no effect in the library explains as well as this does: {EFFECTS[like].summary}"
    if base is not None and base.repeat_drift > base.log_evidence_without_open - base.log_evidence_without:
        return (
            "there is a gap within what passes for scatter: repeats drift with the run order within sessions"
        )
    if base is None or not base.remainder_law:
        return "there is a gap, and a nameless smooth term explains it better than any effect in the library"
    quantity, setting = (name.replace("_", " ") for name in base.remainder_law)
    return f"there is a gap, best explained as if {quantity} changed with {setting}: no effect in the library does that"


def in_words(effects: Effects) -> str:
    """A set of effects as text."""
    if effects == NONE:
        return "no effect"
    if effects == UNKNOWN:
        return "an effect that the library lacks"
    return " with ".join(name.replace("_", " ") for name in effects)
