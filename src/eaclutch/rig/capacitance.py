"""Capacitance against normal force: the bench's csv files and the lab's workbooks, joined."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from eaclutch.records import Campaign, CapacitanceReadings, InputError
from eaclutch.rig.log_names import run_of
from eaclutch.rig.small_tables import numbers, read_rows
from eaclutch.rig.workbook import read_sheets

NAMES = ("force_n", "capacitance_pf", "width_mm", "trial")

_Trial = tuple[
    tuple[str, str], np.ndarray
]  # (source, trial), rows of force [N], capacitance [pF], width [mm]


def read_capacitance(campaign: Campaign) -> CapacitanceReadings:
    """All readings of the campaign, in SI: force [N], capacitance [F], width [m], (readings,).

    ``trial`` is unique over all files: ``<file>/<trial>``. Raises InputError naming file, sheet and row.
    """
    trials = [
        trial
        for path in campaign.capacitance_files
        for trial in (_workbook(path) if path.suffix == ".xlsx" else _csv(path))
    ]
    table = np.concatenate([rows for _, rows in trials]) if trials else np.empty((0, 3))
    labels = [label for label, rows in trials for _ in range(len(rows))]
    return CapacitanceReadings(
        force=table[:, 0],
        capacitance=table[:, 1] * 1e-12,
        width=table[:, 2] * 1e-3,
        trial=tuple(f"{source}/{trial}" for source, trial in labels),
        source=tuple(source for source, _ in labels),
    )


def _csv(path: Path) -> list[_Trial]:
    rows = read_rows(path, NAMES, header=True)
    table = numbers(path, rows, (0, 1, 2))
    _check(path, [number for number, _ in rows], table)
    labels = [cells[3] for _, cells in rows]
    widths: dict[str, set[float]] = {}
    for label, width in zip(labels, table[:, 2].tolist(), strict=True):
        widths.setdefault(label, set()).add(width)
    trials = []
    for label, found in widths.items():
        for width in sorted(found):
            mask = np.array([other == label for other in labels]) & (table[:, 2] == width)
            # trials may be numbered anew for each width
            name = label if len(found) == 1 else f"{label} w={width:g}"
            trials.append(((run_of(path), name), table[mask]))
    return trials


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
