"""What a simulated campaign is to hold: the runs in order of time, the timing of a record, the side benches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, datetime, timedelta
from typing import Any

import numpy as np

from eaclutch.records import InputError


@dataclass(frozen=True)
class PlannedRun:
    """One run: when, and under which conditions (SI); ``preload`` [N] is the one the simulated clutch has."""

    stamp: datetime
    voltage: float
    frequency: float
    width: float
    preload: float
    substrate: str = "brass"


@dataclass(frozen=True)
class RecordTiming:
    """Timing of a record [s]: the stage starts at 0, the voltage comes at ``before``, the stage stops when it has
    gone ``travel`` [m] since, and the record ends ``after`` later. The tip meets the strip at a chance moment
    within ``contact``; what comes before shows the zero. Defaults are the rig's."""

    before: float = 2.0
    travel: float = 1.5e-3
    after: float = 2.0
    sample_interval: float = 78.125e-6
    contact: tuple[float, float] = (0.03, 0.4)


@dataclass(frozen=True)
class SideBenches:
    """What the other benches recorded: capacitance trials, permittivity sources, load-cell logs; 0 for none."""

    capacitance_widths: tuple[float, ...] = (2e-3, 2.5e-3, 3e-3)
    capacitance_trials: int = 2
    capacitance_readings: int = 60
    capacitance_force: tuple[float, float] = (0.1, 4.0)
    permittivity_sources: int = 2
    permittivity_points: int = 30
    permittivity_frequency: tuple[float, float] = (1e2, 3e6)
    load_cell_logs: int = 2


@dataclass(frozen=True)
class Plan:
    """A whole campaign to simulate. ``extension`` of the logs: .csv, .csv.gz, .csv.xz or .npy."""

    runs: tuple[PlannedRun, ...]
    timing: RecordTiming = RecordTiming()
    side: SideBenches = SideBenches()
    extension: str = ".csv.xz"
    faults: Mapping[str, float] = field(default_factory=dict)


def sweep(
    conditions: Sequence[Mapping[str, Any]], sessions: Sequence[date], repeats: int, rng: np.random.Generator
) -> tuple[PlannedRun, ...]:
    """Runs of a design: every condition ``repeats`` times, spread over the sessions, order shuffled in each.

    conditions: mappings with voltage_v, frequency_hz, width_mm, preload_n and optionally substrate, sessions
    (indices of the sessions in which it is run; default all of them in turn) and repeats.
    """
    by_session: list[list[Mapping[str, Any]]] = [[] for _ in sessions]
    for number, condition in enumerate(conditions):
        allowed = condition.get("sessions", range(len(sessions)))
        for repeat in range(int(condition.get("repeats", repeats))):
            by_session[list(allowed)[(number + repeat) % len(allowed)]].append(condition)
    runs = []
    for day, members in zip(sessions, by_session, strict=True):
        stamp = datetime(day.year, day.month, day.day, 14, 0, 0)
        for index in rng.permutation(len(members)):
            stamp += timedelta(seconds=int(rng.integers(40, 150)))
            runs.append(_planned(stamp, members[index]))
    return tuple(runs)


def _planned(stamp: datetime, condition: Mapping[str, Any]) -> PlannedRun:
    try:
        return PlannedRun(
            stamp=stamp,
            voltage=float(condition["voltage_v"]),
            frequency=float(condition["frequency_hz"]),
            width=float(condition["width_mm"]) * 1e-3,
            preload=float(condition["preload_n"]),
            substrate=str(condition.get("substrate", "brass")),
        )
    except KeyError as missing:
        raise InputError(
            "plan", f"a condition has no {missing.args[0]}", "give every condition all keys"
        ) from None
