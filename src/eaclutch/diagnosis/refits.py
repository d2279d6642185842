"""Fits made once more, from where others stand or afresh: what an effect gains must not be that another fit stopped
short."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.spread import Spread
from eaclutch.diagnosis.study import Study

Counted = Callable[[CandidateResult], float]

CLOSE = 10.0  # nats behind what leads beyond which a fit at the usual tolerances is not made again


@dataclass(frozen=True)
class Fit:
    """One fit to be made: what ``Study.weigh`` is given."""

    effects: tuple[str, ...]
    seeds: Mapping[str, float] | None = None
    beyond: HypothesisFit | None = None
    afresh: tuple[float, float] | None = None


def keep_better(
    spread: Spread, results: list[CandidateResult], fits: Sequence[Fit], counted: Counted
) -> None:
    """Makes ``fits`` and puts each into ``results`` where it counts for more than the fit of the same effects there."""
    place = {result.effects: i for i, result in enumerate(results)}
    for made in spread(weigh_fit, fits):
        i = place[made.effects]
        results[i] = max(results[i], made, key=counted)


def weigh_fit(study: Study, fit: Fit) -> CandidateResult:
    return study.weigh(fit.effects, fit.seeds, fit.beyond, afresh=fit.afresh)


def worth_again(
    study: Study, results: Sequence[CandidateResult], beside: Sequence[CandidateResult], counted: Counted
) -> list[CandidateResult]:
    """Those of ``results`` that a second fit might bring near the best of ``beside``: any around a large gap, where it
    may gain tens of nats; at the usual tolerances, where it gains a few, what stands close."""
    lead = max(map(counted, beside))
    return [r for r in results if is_wide(study, r) or counted(r) > lead - CLOSE]


def again(single: CandidateResult, other: CandidateResult) -> Fit:
    """The same fit from the calibrated parameters of another."""
    return Fit(single.effects, seeds_of([single]) | seeds_of([other]))


def afresh(study: Study, results: Sequence[CandidateResult]) -> list[Fit]:
    """The same fits from scratch, with the wider tolerances that they needed, of those that needed any."""
    return [Fit(r.effects, afresh=r.multipliers) for r in results if is_wide(study, r)]


def is_wide(study: Study, result: CandidateResult) -> bool:
    """Whether a fit leaves a gap that needs wider tolerances than an evidence may take."""
    return result.multipliers[0] > max(study.thresholds["multipliers"]["tolerance"]["values"])


def seeds_of(singles: Sequence[CandidateResult]) -> dict[str, float]:
    """Where two effects' own fits stand: the stronger one's calibrated parameters, both ones' own."""
    seeds: dict[str, float] = {}
    for single in sorted(singles, key=lambda r: r.log_evidence):
        seeds |= single.named
    return seeds
