"""Every hypothesis weighed on simulated campaigns of the open namespace: what the other scripts here count and fit on.

Each case is kept in ``<work>/weighed`` as soon as it is done.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from open_campaigns import Job, for_each, made

from eaclutch.blind import plan
from eaclutch.diagnosis.closure import surely_left
from eaclutch.diagnosis.pairs import with_pairs
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.study import Study
from eaclutch.files import read_json, write_json

PAIRS = 6


@dataclass(frozen=True)
class Weighed:
    """A hypothesis on one campaign: what ``probabilities`` and ``decide`` look at."""

    effects: tuple[str, ...]
    log_evidence: float
    log_evidence_open: float
    log_evidence_without: float
    log_evidence_without_open: float
    log_density: tuple[float, ...]
    gap_left_out: float
    adequate_p: float
    multipliers: tuple[float, float]
    left: float
    remainder_law: tuple[str, ...]
    repeat_drift: float


def weigh_case(job: Job) -> None:
    """Make one case and weigh every hypothesis on it."""
    if not kept(job).is_file():
        weigh_campaign(job, *made(job))


def kept(job: Job) -> Path:
    """The file that keeps what a case's hypotheses are weighed by."""
    entry, work = job
    return work / "weighed" / f"{entry.case}.json"


def weigh_campaign(job: Job, answer: Mapping[str, Any], study: Study) -> None:
    """Weigh every hypothesis on a case's campaign and keep what they are weighed by."""
    found = [study.weigh(()), *(study.weigh((name,)) for name in study.candidates)]
    found = with_pairs(study, found, PAIRS)
    write_json(kept(job), {"answer": answer, "weighed": rows_of(study, found)})


def read_case(job: Job) -> tuple[Any, list[Weighed]]:
    """(answer, hypotheses) of a case that is done."""
    document = read_json(kept(job))
    return document["answer"], [Weighed(tuple(e), *numbers) for e, *numbers in document["weighed"]]


def rows_of(study: Study, found: Sequence[CandidateResult]) -> list[list[Any]]:
    """The fields of ``Weighed`` of each hypothesis, as they are written."""
    left = surely_left(study, found)
    return [
        [
            list(r.effects),
            r.log_evidence,
            r.log_evidence_open,
            r.log_evidence_without,
            r.log_evidence_without_open,
            r.log_density,
            r.gap_left_out,
            r.adequate_p,
            r.multipliers,
            left[r.effects],
            r.remainder_law,
            r.repeat_drift,
        ]
        for r in found
    ]


def weigh_all(entries: Sequence[plan.Entry], work: Path, jobs: int) -> list[tuple[Any, list[Weighed]]]:
    """(answer, hypotheses) of every case, made and weighed where that is not done yet."""
    for_each(weigh_case, entries, work, jobs)
    return [read_case((entry, work)) for entry in entries]


def rows_left(rows: Sequence[Weighed]) -> dict[tuple[str, ...], float]:
    """How many times the base model's gap left out each hypothesis surely leaves."""
    return {row.effects: row.left for row in rows}
