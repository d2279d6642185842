"""From the bytes of one transfer to four columns that are certain, or a named fault.

The protocol has no checksum. What stands in for one: the count, repeated five times; the fixed number of
decimals; the clock's steady step; the flag's single pulse; and that every force and voltage lies on its
converter's grid, so that a lost sign or digit moves a value off it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from eaclutch.records import FloatArray
from eaclutch.rig.link.protocol import (
    FORCE_STEP,
    MEMORY_SAMPLES,
    VOLTAGE_STEP,
    Columns,
    Timing,
)

LARGEST_FORCE = 50.0  # N
MOST_REPAIRS = 5
GRID_TOLERANCE = 0.005  # of a converter step; the published logs keep 0.0025
_BLOCKS = ("time", "force", "flag", "voltage")
_LINE = {
    "time": re.compile(rb"(?:0|[1-9]\d{0,9})(?:\.0{1,6})?", re.ASCII),
    "force": re.compile(rb"-?(?:0|[1-9]\d?)\.\d{8}", re.ASCII),
    "flag": re.compile(rb"[01](?:\.0{1,6})?", re.ASCII),
    "voltage": re.compile(rb"-?(?:0|[1-9]\d{0,3})\.\d{6}", re.ASCII),
}
_WHOLE = {name: re.compile(rb"(?:" + line.pattern + rb"\r\n)*", re.ASCII) for name, line in _LINE.items()}
_COUNT = re.compile(rb"[1-9]\d{0,5}", re.ASCII)
_ANY_END = re.compile(rb"\r\n|\r|\n")
_GLUED = re.compile(
    rb"(-?(?:0|[1-9]\d?)\.\d{8})(-?(?:0|[1-9]\d?)\.\d{8})|(-?(?:0|[1-9]\d{0,3})\.\d{6})(-?(?:0|[1-9]\d{0,3})\.\d{6})"
)


class TransferFault(Exception):
    """A transfer that cannot be trusted. ``code``: a stable word; ``detail``: where and what."""

    def __init__(self, code: str, detail: str):
        self.code, self.detail = code, detail
        super().__init__(f"{code}: {detail}")


@dataclass(frozen=True)
class Transfer:
    """One accepted transfer: its columns, what was repaired (stable words), and what was checked."""

    columns: Columns
    repairs: tuple[str, ...]
    checks: dict[str, float | int | str | None]


@dataclass(frozen=True)
class Grid:
    """The converters' steps: force [N], voltage [V]; None where unknown, and then not checked."""

    force: float | None = FORCE_STEP
    voltage: float | None = VOLTAGE_STEP


def announced_lines(raw: bytes | bytearray) -> int | None:
    """How many lines the reply will have in all, from its first line; None while that is not there.

    Raises TransferFault where the first line is no count.
    """
    end = raw.find(b"\n", 0, 64)
    if end < 0:
        if len(raw) >= 64:
            raise TransferFault("no_count", f"the reply begins with {bytes(raw[:24])!r}")
        return None
    return 4 * _count(bytes(raw[:end]).rstrip(b"\r")) + 5


def parse_transfer(raw: bytes, timing: Timing, grid: Grid | None = None) -> Transfer:
    """The columns that ``raw`` says. Reads exactly the announced lines, then demands the separator.

    Raises TransferFault for everything else. Repairs only what leaves no choice: a lost CR or LF, and two
    numbers of fixed decimals that ran together.
    """
    grid = Grid() if grid is None else grid
    lines, repairs = _lines(raw)
    count = _count(lines[0])
    if len(lines) != 4 * count + 5:
        what = f"{len(lines)} lines, {4 * count + 5} were announced"
        raise TransferFault("lines_lost" if len(lines) < 4 * count + 5 else "lines_added", what)
    separator = b"%d" % count
    values = []
    for index, name in enumerate(_BLOCKS):
        start = 1 + index * (count + 1)
        if lines[start + count] != separator:
            what = f"after {count} values of {name} stands {lines[start + count][:24]!r} instead of {count}"
            raise TransferFault("no_separator", what)
        values.append(_numbers(name, lines[start : start + count]))
    columns = Columns(*values)
    if len(repairs) > MOST_REPAIRS:
        raise TransferFault("too_many_repairs", f"{len(repairs)} line endings are damaged")
    return Transfer(columns, repairs, {"lines": len(lines), "count": count, **_check(columns, timing, grid)})


def _lines(raw: bytes) -> tuple[list[bytes], tuple[str, ...]]:
    """The lines of the reply, mended where the mend is certain."""
    if not raw:
        raise TransferFault("silence", "not a byte came")
    if raw[-1:] != b"\n":
        raise TransferFault("cut_short", f"the reply ends in {raw[-24:]!r}")
    lines = raw[:-2].split(b"\r\n") if raw.endswith(b"\r\n") else []
    if lines and _COUNT.fullmatch(lines[0]) and len(lines) == 4 * int(lines[0]) + 5:
        return lines, ()
    repairs = []
    lines = _ANY_END.split(raw)[:-1]
    endings = raw.count(b"\r\n")
    repairs += ["line_ending"] * (len(lines) - endings)
    mended: list[bytes] = []
    for line in lines:
        glued = _GLUED.fullmatch(line) if line.count(b".") == 2 else None
        if glued:
            mended += [part for part in glued.groups() if part is not None]
            repairs.append("merged_lines")
        else:
            mended.append(line)
    return mended, tuple(repairs)


def _count(line: bytes) -> int:
    if not _COUNT.fullmatch(line):
        raise TransferFault("no_count", f"the reply begins with {line[:24]!r}")
    count = int(line)
    if not 2 <= count <= MEMORY_SAMPLES:
        raise TransferFault("no_count", f"the rig holds {MEMORY_SAMPLES} samples, {count} are announced")
    return count


def _numbers(name: str, lines: list[bytes]) -> FloatArray:
    block = b"\r\n".join(lines) + b"\r\n"
    if _WHOLE[name].fullmatch(block) is None:
        row, bad = next((i, line) for i, line in enumerate(lines) if _LINE[name].fullmatch(line) is None)
        raise TransferFault("not_a_number", f"{name} {row + 1} of {len(lines)} is {bad[:24]!r}")
    return np.array(lines, dtype=np.bytes_).astype(np.float64)


def _check(columns: Columns, timing: Timing, grid: Grid) -> dict[str, float | int | str | None]:
    """Raise TransferFault where a column cannot be what the rig recorded; else the margins that were met."""
    steps = np.diff(columns.time_us)
    period = timing.sample_period * 1e6
    if steps.min() < 0.5 * period or steps.max() > 1.5 * period:
        row = int(np.argmax(np.abs(steps - period)))
        what = f"{columns.time_us[row]:.0f} is followed by {columns.time_us[row + 1]:.0f} us (row {row + 2})"
        raise TransferFault("time_jumps", what)
    if np.count_nonzero(np.diff(columns.flag) > 0) > 1 or np.count_nonzero(np.diff(columns.flag) < 0) > 1:
        raise TransferFault("flag_not_one_pulse", "the flag rises or falls more than once")
    largest = float(np.abs(columns.force).max())
    if largest > LARGEST_FORCE:
        raise TransferFault("force_out_of_range", f"{largest:g} N")
    return {
        "time_step_min_us": float(steps.min()),
        "time_step_max_us": float(steps.max()),
        "force_grid_residual": _on_grid("force", columns.force, grid.force),
        "voltage_grid_residual": _on_grid("voltage", columns.voltage, grid.voltage, 0.0),
    }


def _on_grid(name: str, values: FloatArray, step: float | None, offset: float | None = None) -> float | None:
    """Largest distance from the converter's grid in steps; its zero is taken from the values where unknown."""
    if step is None:
        return None
    turns = values / step
    if offset is None:
        offset = float(np.angle(np.exp(2j * np.pi * turns).mean())) / (2 * np.pi) * step
    turns = turns - offset / step
    distance = np.abs(turns - np.round(turns))
    row = int(np.argmax(distance))
    if distance[row] > GRID_TOLERANCE:
        what = f"{values[row]:.8g} (row {row + 1}) is {distance[row]:.2f} of a converter step off"
        raise TransferFault(f"{name}_off_grid", what)
    return float(distance[row])
