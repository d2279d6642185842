"""Named columns of a (compressed) csv text, read fast, with bounded memory and one clear error."""

from __future__ import annotations

import gzip
import io
import lzma
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.records import InputError

BYTES_PER_ROW = 80  # a rig's row has 30 .. 45
BAD_SHARE = 0.001  # of the rows that may be unreadable before the file is refused
_OPEN: dict[str, Callable[..., Any]] = {".gz": gzip.open, ".xz": lzma.open}


def read_csv_columns(path: Path, names: Sequence[str], *, longest: int) -> tuple[np.ndarray, tuple[str, ...]]:
    """The columns ``names`` of a csv file as float64 of shape (rows, len(names)), and flags.

    Flags: ``bad_rows`` (lines that are no rows were left out), ``bad_cells`` (cells that are no numbers are
    NaN), ``columns_reordered`` (by their names), ``cut_short`` (the last line or the compressed stream ends early).
    Raises InputError for a missing column, more than ``longest`` rows or 0.1 % unreadable rows.
    """
    text, cut = bounded_bytes(path, longest * BYTES_PER_ROW)
    head, _, body = text.partition(b"\n")
    delimiter, order = _columns(path.name, head, names)
    flags = ["columns_reordered"] if order != sorted(order) else []
    if body and not body.endswith(b"\n"):
        # the last line may be half a line, and half a number is a wrong number
        body, _, rest = body.rpartition(b"\n")
        if cut or rest.count(delimiter) != head.count(delimiter):
            flags.append("cut_short")
        else:
            body += b"\n" + rest
    elif cut:
        flags.append("cut_short")
    fields = head.count(delimiter) + 1
    try:
        frame = pd.read_csv(
            io.BytesIO(body),
            sep=delimiter.decode(),
            header=None,
            names=list(range(fields)),
            dtype=np.float64,
            engine="c",
            index_col=False,
            quoting=3,
            na_values=["nan", "NaN", ""],
            keep_default_na=False,
            skip_blank_lines=False,
            low_memory=False,
        )
        table = frame.to_numpy()
        if np.isnan(table).any():
            raise ValueError("cells are missing")
    except (ValueError, pd.errors.ParserError, pd.errors.ParserWarning, UnicodeDecodeError):
        table, found = _tolerant(path.name, body, delimiter, fields)
        flags += found
    if len(table) > longest:
        raise InputError(
            path.name, f"{len(table)} rows, at most {longest} can be a run", "split the recording"
        )
    return table[:, order], tuple(flags)


def bounded_bytes(path: Path, limit: int) -> tuple[bytes, bool]:
    """The file's text up to ``limit`` bytes, and whether a compressed stream ended early."""
    opener = _OPEN.get(path.suffix)
    chunks, size = [], 0
    try:
        with opener(path, "rb") if opener else path.open("rb") as stream:
            while chunk := stream.read(1 << 20):
                chunks.append(chunk)
                size += len(chunk)
                if size > limit:
                    what = f"more than {limit // 1_000_000} MB of text"
                    raise InputError(path.name, what, "a run is far shorter: split or remove the file")
    except InputError:
        raise
    except (EOFError, lzma.LZMAError, zlib.error, gzip.BadGzipFile) as error:
        if size == 0:
            what = f"the compressed file is damaged ({error})"
            raise InputError(path.name, what, "copy the file again from the rig") from None
        return b"".join(chunks).replace(b"\r\n", b"\n"), True
    except OSError as error:
        raise InputError(path.name, error.strerror or "cannot be read", "check the file") from None
    text = b"".join(chunks)
    return (text.replace(b"\r\n", b"\n") if b"\r" in text else text), False


def _columns(file: str, head: bytes, names: Sequence[str]) -> tuple[bytes, list[int]]:
    """The delimiter and where each wanted column stands, from the header line."""
    remedy = f"the first row must name the columns {', '.join(names)}"
    try:
        line = head.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise InputError(f"{file}, row 1", "is not text", remedy) from None
    for delimiter in (",", ";", "\t"):
        titles = [title.strip().strip('"') for title in line.split(delimiter)]
        if all(titles.count(name) == 1 for name in names):
            return delimiter.encode(), [titles.index(name) for name in names]
    shown = "".join(c if c.isprintable() else "?" for c in line[:60])
    raise InputError(f"{file}, row 1", f"the header is '{shown}'", remedy)


def _tolerant(file: str, body: bytes, delimiter: bytes, fields: int) -> tuple[np.ndarray, list[str]]:
    """Line by line, where the fast way failed: what is no number is NaN, what is no row is left out."""
    lines = body.split(b"\n")
    if lines and not lines[-1].strip():
        lines.pop()
    rows, bad_rows, bad_cells, first_bad = [], 0, 0, 0
    for number, line in enumerate(lines, start=2):
        cells = line.split(delimiter)
        if len(cells) != fields:
            bad_rows += 1
            first_bad = first_bad or number
            continue
        row = [_number(cell) for cell in cells]
        if any(value != value for value in row):
            bad_cells += 1
            first_bad = first_bad or number
        rows.append(row)
    if bad_rows + bad_cells > max(3, BAD_SHARE * len(lines)):
        what = f"{bad_rows + bad_cells} of {len(lines)} rows from here on cannot be read"
        raise InputError(f"{file}, row {first_bad}", what, "copy the file again or remove it")
    flags = ["bad_rows"] * bool(bad_rows) + ["bad_cells"] * bool(bad_cells)
    return np.array(rows, dtype=float).reshape(-1, fields), flags


def _number(cell: bytes) -> float:
    try:
        value = float(cell) if b"_" not in cell else np.nan
    except ValueError:
        return np.nan
    return value if np.isfinite(value) else np.nan
