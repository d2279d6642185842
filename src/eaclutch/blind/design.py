"""Sixty runs, twenty conditions, three sessions, confounded the way the published campaign is."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from eaclutch.records import FloatArray, RunSettings
from eaclutch.rig.logs import log_name

THICKNESS = {2.0: 2.0, 2.5: 2.5, 3.0: 3.0, 4.0: 2.0, 5.0: 2.5, 6.0: 3.0}  # mm by width, as published
PRELOAD_EDGES = (0.25, 0.75, 1.5)  # N
SUBSTRATE = "brass"
DC = 0.1  # Hz, the rig's way to write it


@dataclass(frozen=True)
class Design:
    """Settings of every run in the order of time, arrays (runs,), SI."""

    settings: tuple[RunSettings, ...]
    session: FloatArray  # index
    session_names: tuple[str, ...]
    order: FloatArray  # in the session
    cell: FloatArray  # index of the condition that was aimed at
    preload_target: FloatArray  # N
    voltage: FloatArray
    frequency: FloatArray
    width: FloatArray
    thickness: FloatArray


def draw_design(rng: np.random.Generator) -> Design:
    """A campaign's runs. Preload is swept in the first session only, V = 250-300 V over frequency in the
    second, 150-200 V in the third, widths at 300 V and 1 kHz; two conditions recur in several sessions.
    """
    slow, fast = (DC, 1.0, 10.0), (100.0, 2000.0, 5000.0, 10000.0)
    first = [(v, 1000.0, 2.0, 0.12) for v in (150.0, 200.0, 250.0, 300.0)]
    first += [(300.0, 1000.0, 2.0, 0.5), (300.0, 1000.0, 2.0, 1.05)]
    first += [(float(rng.choice([200.0, 250.0])), 1000.0, 2.0, 0.5)]
    second, third = [], []
    for level in (300.0, 250.0):
        for f in (DC, rng.choice(slow[1:]), rng.choice(fast)) if level == 300.0 else _mixed(slow, fast, rng):
            second.append((level, float(f), 2.0, 0.1))
    for level in (200.0, 150.0):
        for f in _mixed(slow, fast, rng)[: 3 if level == 200.0 else 2]:
            third.append((level, float(f), 2.0, 0.12))
    widths = [float(w) for w in rng.permutation([2.5, 3.0, 4.0, 5.0, 6.0])[:2]]
    third += [(300.0, 1000.0, w, 0.12) for w in widths]
    cells = first + second + third  # 7 + 6 + 7
    plan: list[tuple[int, int]] = []  # (session, cell)
    shared = {3: (1, 1, 1), 1: (2, 0, 1)}  # 300 V and 200 V at 1 kHz come back
    for index in range(len(cells)):
        home = 0 if index < len(first) else 1 if index < len(first) + len(second) else 2
        if index in shared:
            plan += [(s, index) for s in range(3) for _ in range(shared[index][s])]
        else:
            plan += [(home, index)] * 3
    days = [
        datetime(2025, 1, 6) + timedelta(days=int(d)) for d in np.sort(rng.choice(300, size=3, replace=False))
    ]
    return _arrange(plan, cells, days, rng)


def _mixed(slow: tuple, fast: tuple, rng: np.random.Generator) -> list:
    return [rng.choice(slow), *rng.permutation(fast)[:2]]


def _arrange(plan: list, cells: list, days: list[datetime], rng: np.random.Generator) -> Design:
    """Order the runs within each session (blocks of a condition, as an operator does, some shuffled)."""
    rows = []
    for session, day in enumerate(days):
        members = [cell for s, cell in plan if s == session]
        blocks = {cell: rng.random() for cell in set(members)}
        keys = [blocks[cell] + rng.normal(0, 0.12) for cell in members]
        clock = day + timedelta(hours=13, minutes=int(rng.integers(0, 90)))
        for order, place in enumerate(np.argsort(keys)):
            clock += timedelta(seconds=int(rng.integers(45, 240)))
            rows.append((session, order, members[place], clock))
    settings, arrays = [], []
    for session, order, cell, stamp in rows:
        voltage, frequency, width, preload = cells[cell]
        draft = RunSettings("", stamp, 1.5e-3, 0.5e-3, None, voltage, frequency, width * 1e-3, SUBSTRATE)
        settings.append(RunSettings(log_name(draft), *_rest(draft)))
        arrays.append(
            (session, order, cell, preload, voltage, frequency, width * 1e-3, THICKNESS[width] * 1e-3)
        )
    table = np.array(arrays, float).T
    return Design(
        settings=tuple(settings),
        session_names=tuple(day.strftime("%Y-%m-%d") for day in days),
        session=table[0],
        order=table[1],
        cell=table[2],
        preload_target=table[3],
        voltage=table[4],
        frequency=table[5],
        width=table[6],
        thickness=table[7],
    )


def _rest(draft: RunSettings) -> tuple:
    return (
        draft.stamp,
        draft.travel,
        draft.speed,
        draft.preload,
        draft.voltage,
        draft.frequency,
        draft.width,
        draft.substrate,
    )
