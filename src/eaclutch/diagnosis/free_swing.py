"""Runs that swing freely after switch-off: a kind of motion that a model either has or has not.

How fast and how long they swing carries no name (``channels``). That they swing at all does: a model without a mass on
its spring has no such motion at any parameter, and no tolerance, which lets a number be a little off, gives it one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

import pandas as pd

from eaclutch.diagnosis.result import CandidateResult

OSCILLATOR = "load_cell_dynamics"
OBSERVABLE = "ringdown_frequency_hz"


def count_swings(table: pd.DataFrame) -> int:
    """Runs of runs.csv in which a free swing was measured."""
    if OBSERVABLE not in table:
        return 0
    return int(pd.to_numeric(table[OBSERVABLE], errors="coerce").notna().sum())


def charged(
    result: CandidateResult, model: Collection[str], swings: int, thresholds: Mapping[str, Any]
) -> CandidateResult:
    """``result`` with what ``swings`` runs cost a hypothesis that cannot swing; ``model``: the effects of the
    campaign's own model, without the result's.

    Each such run would have to be taken for a swing by mistake. A nameless term beside the base model stands for what
    nobody wrote down, and that may swing: it pays for being of that kind, no more. Beside a named effect it must not,
    for the name would then not be what explains it.
    """
    rule = thresholds["free_swing"]
    cost = min(swings * float(rule["run"]), float(rule["most"]))
    if cost == 0.0 or OSCILLATOR in model:
        return result
    found = replace(
        result,
        log_evidence_without=result.log_evidence_without - cost,
        log_evidence_without_open=result.log_evidence_without_open - min(cost, float(rule["nameless"])),
    )
    if OSCILLATOR in result.effects:
        return found
    return replace(
        found,
        log_evidence=result.log_evidence - cost,
        log_evidence_open=result.log_evidence_open - cost,
    )
