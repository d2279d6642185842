"""Capacitance against normal force: the bench's csv files and the lab's workbooks, joined."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from eaclutch.records import Bench, Campaign, CapacitanceReadings, InputError
from eaclutch.rig.log_names import run_of
from eaclutch.rig.small_tables import numbers, read_rows
from eaclutch.rig.workbook import read_sheets

NAMES = ("force_n", "capacitance_pf", "width_mm", "trial")


@dataclass(frozen=True)
class LeftOut:
    """A trial that is not used, and why."""

    source: str
    trial: str
    width: float
    reason: str


def read_capacitance(campaign: Campaign) -> CapacitanceReadings:
    """All readings of the campaign, in SI: force [N], capacitance [F], width [m], (readings,).

    Trials at a width that none of the bench's substrates has are left out (``left_out`` names them).
    """
    kept, _ = _split(campaign)
    parts = [part for _, part in kept]
    table = np.concatenate(parts) if parts else np.empty((0, 3))
    labels = [label for label, part in kept for _ in range(len(part))]
    return CapacitanceReadings(
        force=table[:, 0],
        capacitance=table[:, 1] * 1e-12,
        width=table[:, 2] * 1e-3,
        trial=tuple(f"{source}/{trial}" for source, trial in labels),
        source=tuple(source for source, _ in labels),
    )


def left_out(campaign: Campaign) -> tuple[LeftOut, ...]:
    """The trials that ``read_capacitance`` leaves out, with the reason."""
    return _split(campaign)[1]


_Trial = tuple[
    tuple[str, str], np.ndarray
]  # (source, trial), rows of force [N], capacitance [pF], width [mm]


def _split(campaign: Campaign) -> tuple[list[_Trial], tuple[LeftOut, ...]]:
    widths = known_widths(campaign.bench)
    kept, out = [], []
    for path in campaign.capacitance_files:
        trials = _workbook(path) if path.suffix == ".xlsx" else _csv(path)
        for label, table in trials:
            strange = [
                w for w in np.unique(table[:, 2]) if widths and np.min(np.abs(np.array(widths) - w)) > 1e-3
            ]
            if strange:
                reason = f"no substrate of this bench is {strange[0]:g} mm wide"
                out.append(LeftOut(*label, strange[0] * 1e-3, reason))
            else:
                kept.append((label, table))
    return kept, tuple(out)


def known_widths(bench: Bench) -> tuple[float, ...]:
    """Widths [mm] that campaign.yaml lists; empty where it lists none."""
    return tuple(sorted({w * 1e3 for substrate in bench.substrates.values() for w in substrate.thickness}))


def _csv(path: Path) -> list[_Trial]:
    rows = read_rows(path, NAMES, header=True)
    table = numbers(path, rows, (0, 1, 2))
    _check(path, [number for number, _ in rows], table)
    names = [cells[3] for _, cells in rows]
    source = run_of(path)
    keys = dict.fromkeys(zip(names, table[:, 2].tolist(), strict=True))
    picked = []
    for name, width in keys:
        mask = np.array([n == name for n in names]) & (table[:, 2] == width)
        label = name if len({w for n, w in keys if n == name}) == 1 else f"{name} w={width:g}"
        picked.append(((source, label), table[mask]))
    return picked


def _workbook(path: Path) -> list[_Trial]:
    trials = []
    for sheet in read_sheets(path):
        table = np.array([(force, capacitance, sheet.width * 1e3) for _, force, capacitance in sheet.rows])
        table = table.reshape(-1, 3)
        _check(f"{path}, sheet {sheet.name}", [number for number, *_ in sheet.rows], table)
        trials.append(((path.stem, sheet.name), table))
    return trials


def _check(where: Path | str, rows: list[int], table: np.ndarray) -> None:
    wrong = (table[:, 0] < 0) | (table[:, 0] > 1e4) | (table[:, 1] <= 0) | (table[:, 2] <= 0)
    if wrong.any():
        i = int(np.argmax(wrong))
        what = f"{table[i, 0]:g} N, {table[i, 1]:g} pF, {table[i, 2]:g} mm is no reading"
        raise InputError(f"{where}, row {rows[i]}", what, "force >= 0, capacitance and width > 0")
