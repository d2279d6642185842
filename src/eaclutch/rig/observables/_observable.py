"""The one shape that all observables share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate
from eaclutch.rig.run_view import RunView

PHASES = ("before", "engage", "ramp", "hold", "release", "ringdown", "after")


@dataclass(frozen=True)
class Observable:
    """What it is, and how it is read off a run (raises Unusable)."""

    info: ObservableInfo
    measure: Callable[[RunView], Estimate]

    def __post_init__(self) -> None:
        if self.info.phase not in PHASES:
            raise ValueError(f"{self.info.name}: phase {self.info.phase} is none of {PHASES}")
