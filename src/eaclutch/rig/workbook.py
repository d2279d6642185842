"""The lab's capacitance workbook: a sheet a trial, cached values only; formulas are never evaluated."""

from __future__ import annotations

import io
import re
import warnings
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from eaclutch.records import InputError

LARGEST = 50_000_000  # bytes once unpacked
MOST_ROWS = 20_000
_SHEET = re.compile(r"\s*w\s*=\s*(\d+(?:\.\d+)?)\s*(?:mm)?\s*\(.*\)\s*", re.DOTALL)


@dataclass(frozen=True)
class Sheet:
    """One trial: sheet name, width [m], rows of (row number, force [N], capacitance [pF])."""

    name: str
    width: float
    rows: tuple[tuple[int, float, float], ...]


def read_sheets(path: Path) -> tuple[Sheet, ...]:
    """The trials of a workbook: force and capacitance are the first two columns of sheets named "w=<mm> (...)".

    Raises InputError for a file that is no workbook, is too large once unpacked, has a formula without a cached
    value, or a cell that is no number where one must be.
    """
    from openpyxl import load_workbook  # 15 MiB that jobs on logs alone need not carry

    try:
        if path.stat().st_size > LARGEST:
            raise InputError(path, "is larger than a bench's workbook", "split the workbook")
        content = path.read_bytes()  # openpyxl leaves a damaged file open
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if sum(item.file_size for item in archive.infolist()) > LARGEST:
                raise InputError(path, "is larger than a bench's workbook", "split the workbook")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # styles and extensions that openpyxl does not know
            values = load_workbook(io.BytesIO(content), data_only=True, read_only=True)
            formulas = load_workbook(io.BytesIO(content), data_only=False, read_only=True)
            try:
                sheets = tuple(
                    Sheet(name, width, _rows(path, name, values[name], formulas[name]))
                    for name in values.sheetnames
                    if (width := _width(name)) is not None
                )
            finally:
                values.close()
                formulas.close()
    except InputError:
        raise
    except Exception as error:  # zip, XML and openpyxl raise many kinds on damaged files
        raise InputError(
            path, f"is not a readable workbook ({type(error).__name__})", "save it again as .xlsx"
        ) from None
    if not sheets:
        raise InputError(path, 'has no sheet named "w=<mm> (...)"', "name the sheets by width")
    return sheets


def _width(name: str) -> float | None:
    found = _SHEET.fullmatch(name)
    return float(found[1]) * 1e-3 if found else None


def _rows(path: Path, sheet: str, values: Any, formulas: Any) -> tuple[tuple[int, float, float], ...]:
    rows = []
    pairs = zip(
        values.iter_rows(min_row=2, max_row=MOST_ROWS, max_col=2, values_only=True),
        formulas.iter_rows(min_row=2, max_row=MOST_ROWS, max_col=2, values_only=True),
        strict=True,
    )
    for number, (value, formula) in enumerate(pairs, start=2):
        value, formula = (*value, None, None)[:2], (*formula, None, None)[:2]
        for cached, text in zip(value, formula, strict=True):
            if cached is None and text is not None:
                what = "a formula has no cached value"
                raise InputError(
                    f"{path}, sheet {sheet}, row {number}", what, "open and save it in a spreadsheet"
                )
        force, capacitance = value
        if force is None and capacitance is None:
            continue
        if not all(isinstance(cell, (int, float)) and not isinstance(cell, bool) for cell in value):
            what = "force or capacitance is not a number"
            raise InputError(f"{path}, sheet {sheet}, row {number}", what, "correct the cell")
        rows.append((number, float(force), float(capacitance)))
    return tuple(rows)
