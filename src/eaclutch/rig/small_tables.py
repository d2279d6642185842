"""Small numeric csv tables (capacitance readings, spectra): every row must be right."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from eaclutch.records import FloatArray, InputError
from eaclutch.rig.csv_columns import bounded_bytes

LARGEST = 8_000_000  # bytes


def read_rows(path: Path, names: Sequence[str], *, header: bool) -> list[tuple[int, list[str]]]:
    """Row number and cells, in the order of ``names``, of a small csv.

    ``header``: the first row must name the columns (found by name); else the names are optional and a first row
    without any number in it is taken for one.
    """
    text = _text(path)
    rows = [
        (number, [cell.strip() for cell in row])
        for number, row in _parsed(path, text)
        if any(map(str.strip, row))
    ]
    if not rows:
        raise InputError(path, "is empty", f"give the columns {', '.join(names)}")
    first = rows[0][1]
    order = list(range(len(names)))
    if all(name in first for name in names):
        order = [first.index(name) for name in names]
        rows = rows[1:]
    elif header:
        raise InputError(
            f"{path}, row {rows[0][0]}", "the header does not name the columns", f"{', '.join(names)}"
        )
    elif not any(map(is_number, first)):
        rows = rows[1:]
    picked = []
    for number, cells in rows:
        if len(cells) <= max(order) or (not header and len(cells) != len(names)):
            raise InputError(f"{path}, row {number}", f"has {len(cells)} cells", f"give {', '.join(names)}")
        picked.append((number, [cells[i] for i in order]))
    return picked


def numbers(path: Path, rows: Sequence[tuple[int, list[str]]], columns: Sequence[int]) -> FloatArray:
    """The given columns of rows as numbers, (rows, columns). Raises InputError naming the row."""
    table = np.empty((len(rows), len(columns)))
    for i, (number, cells) in enumerate(rows):
        for j, column in enumerate(columns):
            if not is_number(cells[column]):
                shown = cells[column][:40]
                raise InputError(f"{path}, row {number}", f"{shown!r} is not a number", "correct the cell")
            table[i, j] = float(cells[column])
    return table


def is_number(cell: str) -> bool:
    """Whether a cell is a finite number."""
    try:
        return bool(np.isfinite(float(cell))) and "_" not in cell
    except ValueError:
        return False


def _text(path: Path) -> str:
    raw, cut = bounded_bytes(path, LARGEST)
    if cut:
        raise InputError(path, "the compressed file ends early", "copy the file again")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = raw[: error.start].count(b"\n") + 1
        raise InputError(f"{path}, row {row}", "is not UTF-8 text", "save it as plain csv") from None


def _parsed(path: Path, text: str) -> list[tuple[int, list[str]]]:
    try:
        return list(enumerate(csv.reader(io.StringIO(text)), start=1))
    except csv.Error as error:
        raise InputError(path, f"is not a csv file ({error})", "save it as plain csv") from None
