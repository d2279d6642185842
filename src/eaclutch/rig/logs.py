"""The rig's logs: .csv, .csv.gz, .csv.xz and .npy, read and written (rig.md: A log)."""

from __future__ import annotations

import gzip
import io
import lzma
from pathlib import Path

import numpy as np

from eaclutch.files import atomic
from eaclutch.records import InputError, Recording
from eaclutch.rig.csv_columns import read_csv_columns
from eaclutch.rig.log_names import EXTENSIONS, log_name, parse_log_name, run_of

__all__ = ["EXTENSIONS", "HEADER", "log_name", "parse_log_name", "read_log", "run_of", "write_log"]

HEADER = ("Time", "Load Cell", "Moving Forward", "Relay Output")
SHORTEST = 100  # samples; less is no run
ABSURD = 1e12  # no column of a run gets there, in any unit that a rig logs
OUT_OF_STEP, OUT_OF_RANGE = (
    0.15,
    0.005,
)  # shares of samples: lost time lines leave a tail of zeros, the rest is stray
LONGEST = 500_000  # samples: twice what the rig can hold


def read_log(path: Path | str) -> Recording:
    """One log as recorded, nothing repaired: time [s], force [N], flag, voltage [V], each (samples,).

    Cells that are not numbers become NaN, and lines that are not rows are left out; both are flagged. Columns
    of a csv are found by their names, in whatever order.
    Raises InputError (file, row) where it cannot be told what the log says.
    """
    path = Path(path)
    settings = parse_log_name(path.name)
    flags: tuple[str, ...] = ()
    if path.suffix == ".npy":
        table = _read_npy(path)
    else:
        table, flags = read_csv_columns(path, HEADER, longest=LONGEST)
    if len(table) < SHORTEST:
        raise InputError(
            path.name, f"{len(table)} rows are no run", "record the run again or remove the file"
        )
    with np.errstate(invalid="ignore"):  # a signalling NaN
        bad = ~(np.abs(table) < ABSURD)
    if bad.any():
        table = np.where(bad, np.nan, table)
        flags = (*flags, "bad_cells") if "bad_cells" not in flags else flags
    _check(path.name, table)
    time, force, flag, voltage = np.ascontiguousarray(table.T)
    return Recording(settings, time * 1e-6, force, flag, voltage, flags)


def write_log(recording: Recording, path: Path | str) -> Path:
    """Write a recording in the rig's format, by the extension of ``path``; returns the path.

    The text has the rig's digits: time in whole microseconds, force to 1e-8 N, voltage to 1e-6 V.
    """
    path = Path(path)
    columns = (np.round(recording.time * 1e6), recording.force, recording.flag, recording.voltage)
    with atomic(path) as temporary:
        if path.suffix == ".npy":
            with Path(temporary).open("wb") as stream:
                np.save(stream, np.stack(columns, axis=1).astype(float), allow_pickle=False)
        else:
            Path(temporary).write_bytes(_compressed(_text(columns), path.name))
    return path


def _text(columns: tuple[np.ndarray, ...]) -> bytes:
    lines = [",".join(HEADER)]
    for time, force, flag, voltage in zip(*(column.tolist() for column in columns), strict=True):
        force, voltage = round(force, 8), round(voltage, 6)
        lines.append(f"{time!r},{force!r},{flag!r},{voltage!r}")
    return ("\n".join(lines) + "\n").encode().replace(b"nan", b"")


def _compressed(text: bytes, name: str) -> bytes:
    if name.endswith(".gz"):
        return gzip.compress(text, 6, mtime=0)
    if name.endswith(".xz"):
        return lzma.compress(text, preset=1)
    return text


def _read_npy(path: Path) -> np.ndarray:
    """The table of an .npy log; its header is looked at before anything is allocated."""
    remedy = "store float64 of shape (n, 4): time, force, flag, voltage"
    try:
        with path.open("rb") as stream:
            version = np.lib.format.read_magic(stream)
            read = (
                np.lib.format.read_array_header_1_0
                if version == (1, 0)
                else np.lib.format.read_array_header_2_0
            )
            shape, _, dtype = read(stream)
            if len(shape) != 2 or shape[1] != 4 or dtype != np.dtype("f8"):
                raise InputError(path.name, f"holds {dtype} of shape {shape}", remedy)
            if shape[0] > LONGEST:
                raise InputError(path.name, f"{shape[0]} rows, the rig holds 250000", "split the recording")
            stream.seek(0)
            longest = 64 * 1024 + 32 * shape[0]  # what follows the array is not looked at
            return np.load(io.BytesIO(stream.read(longest)), allow_pickle=False)
    except InputError:
        raise
    except OSError as error:
        raise InputError(path.name, error.strerror or "cannot be read", "check the file") from None
    except Exception as error:  # numpy raises many kinds on damaged headers
        raise InputError(path.name, f"is not a readable .npy file ({error})", remedy) from None


def _check(name: str, table: np.ndarray) -> None:
    """Refuse tables whose columns cannot be what the header says (swapped, other units, all empty)."""
    time, force, flag, voltage = table.T
    remedy = (
        "check the order of the columns: Time [us], Load Cell [N], Moving Forward [0/1], Relay Output [V]"
    )
    for column, values in zip(HEADER, table.T, strict=True):
        good = np.isfinite(values)
        if good.mean() < 0.5:
            row = int(np.argmin(good)) + 2
            raise InputError(f"{name}, row {row}", f"most of the column {column} is not numbers", remedy)
    steps = np.diff(time)
    with np.errstate(invalid="ignore"):
        wrong = {
            "Time": ~(steps > 0),
            "Load Cell": np.abs(force) > 50.0,
            "Moving Forward": (flag != 0) & (flag != 1) & np.isfinite(flag),
            "Relay Output": np.abs(voltage) > 1e4,
        }
    for column, bad in wrong.items():
        if bad.mean() > (OUT_OF_STEP if column == "Time" else OUT_OF_RANGE):
            what = {"Time": "does not increase", "Moving Forward": "is not 0 or 1"}.get(
                column, "is out of range"
            )
            raise InputError(f"{name}, row {int(np.argmax(bad)) + 2}", f"{column} {what}", remedy)
    median = float(np.nanmedian(steps))
    if not 5.0 <= median <= 2000.0:
        raise InputError(name, f"one sample every {median:g} us", "record with 0.5 to 200 kHz, time in us")
