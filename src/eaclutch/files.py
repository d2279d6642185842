"""Writing results so that a reader never meets half a file, and equal numbers give equal bytes."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import math
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.records import InputError

# Nine significant digits: far below any uncertainty here, and above the last bits in which
# sums of another order may differ.
DIGITS = 9
# Columns of tables that hold names, not numbers.
NAMES = ("run", "session", "condition", "substrate", "flags", "reasons", "reason", "trial", "source",
         "observable", "status", "split")  # fmt: skip


@contextlib.contextmanager
def atomic(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside ``path`` that takes its place when the block ends well.

    The folder is made if needed. On an exception the temporary file is removed and ``path`` is as it was.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=path.suffix, dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        with temporary.open("rb+") as stream:
            os.fsync(stream.fileno())
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def plain(value: Any) -> Any:
    """``value`` as JSON can say it: arrays to lists, records to objects, floats at nine digits, NaN to null."""
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set, frozenset, np.ndarray)):
        items = sorted(value) if isinstance(value, (set, frozenset)) else value
        return [plain(item) for item in items]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (float, np.floating)):
        number = float(value)
        return float(f"{number:.{DIGITS}g}") if math.isfinite(number) else None
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write ``text`` as UTF-8, atomically."""
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def write_json(path: str | os.PathLike[str], value: Any) -> None:
    """Write ``value`` as JSON: keys sorted, floats at nine significant digits, NaN and infinities as null."""
    text = json.dumps(plain(value), indent=1, sort_keys=True, allow_nan=False, ensure_ascii=False)
    write_text(path, text + "\n")


class Document(dict[str, Any]):
    """A JSON object that knows where it was read: a key that it lacks is an error for the reader's eyes."""

    def __init__(self, where: object, content: Mapping[str, Any]):
        super().__init__(content)
        self.where = where

    def __missing__(self, key: str) -> Any:
        raise InputError(self.where, f"lacks {key!r}", "make it again")


def read_json(path: str | os.PathLike[str], kind: type[dict[str, Any]] | type[list[Any]] = dict) -> Any:
    """What ``write_json`` wrote, an object unless ``kind`` is list. Raises InputError where it is not that."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise InputError(path, f"is not JSON ({error})", "make it again") from error
    if not isinstance(content, kind):
        raise InputError(path, f"holds no JSON {'object' if kind is dict else 'array'}", "make it again")
    return Document(path, content) if isinstance(content, dict) else content


def write_csv(path: str | os.PathLike[str], table: pd.DataFrame | Iterable[pd.DataFrame]) -> None:
    """Write a table without its index: nine significant digits, true/false, empty cells for missing values.

    Tables of the same columns, one after the other, make one file.
    """
    with atomic(path) as temporary:
        for number, part in enumerate([table] if isinstance(table, pd.DataFrame) else table):
            shown = part.copy()
            for name in shown.columns:
                if pd.api.types.is_bool_dtype(shown[name]):
                    shown[name] = shown[name].map({True: "true", False: "false"})
            shown.to_csv(
                temporary, mode="a" if number else "w", header=not number, index=False,
                float_format=f"%.{DIGITS}g", lineterminator="\n", compression=None,
            )  # fmt: skip


def read_table(path: str | os.PathLike[str]) -> pd.DataFrame:
    """A table of results. A name stays the text that it is (session ``01`` is not ``1``, condition ``NA`` is no gap in
    the table); an empty cell of names is the empty text. Raises InputError where the file is no table."""
    try:
        columns = pd.read_csv(path, nrows=0).columns
        missing = {name: ["", "nan", "NaN", "NA"] for name in columns if name not in NAMES}
        return pd.read_csv(path, dtype=dict.fromkeys(NAMES, str), keep_default_na=False, na_values=missing)
    except pd.errors.EmptyDataError:
        return pd.DataFrame()
    except (pd.errors.ParserError, UnicodeDecodeError) as error:
        raise InputError(path, f"unreadable ({error})", "rebuild it") from error


def sha256(path: str | os.PathLike[str]) -> str:
    """SHA-256 of a file's bytes, in hexadecimal."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def hold(path: str | os.PathLike[str]) -> int:
    """Take the lock file ``path``; it is free again when the handle is closed or this process ends, however it ends.

    Returns the handle. Raises BlockingIOError where another process holds it.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        raise
    return handle
