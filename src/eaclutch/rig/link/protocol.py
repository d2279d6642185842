"""What host and rig say to each other: two command bytes, then four announced blocks of lines.

The rig is silent while it moves, then sends ``N``, N time stamps, ``N``, N forces, ``N``, N flags, ``N``,
N voltages, ``N``, each line ending in CR LF. The count is also the separator, and a data value may equal it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from eaclutch.records import FloatArray, InputError

BAUD = 115_200  # nominal: USB ignores it
MEMORY_SAMPLES = 250_000
TRAVEL_UNIT = 1e-4  # m a count of the first command byte
SPEED_UNIT = 5e-5  # m/s a count of the second
LINE_END = b"\r\n"
FORCE_DECIMALS = 8
VOLTAGE_DECIMALS = 6
# Found in all published logs: the converter's step, and the divider's (rig.md: One run).
FORCE_STEP = 5.0792797e-5  # N
FORCE_OFFSET = -0.112957877  # N
VOLTAGE_STEP = 0.344  # V


@dataclass(frozen=True)
class Timing:
    """How the firmware spends a run: rest before and after the drive [s], sample period [s]."""

    before: float = 2.0
    after: float = 2.0
    sample_period: float = 1.0 / 12_800.0


@dataclass(frozen=True)
class BenchSetting:
    """What the operator sets by hand: supply, frequency, substrate, weight (SI; preload None = not set)."""

    voltage: float
    frequency: float
    width: float
    substrate: str
    preload: float | None = None


@dataclass(frozen=True)
class Command:
    """One run: how far the stage travels with the voltage on [m], and how fast [m/s]."""

    travel: float
    speed: float

    def encode(self) -> bytes:
        """The two bytes on the wire. Raises InputError where the protocol cannot say it."""
        return bytes(
            (_byte("travel", self.travel, TRAVEL_UNIT, "mm"), _byte("speed", self.speed, SPEED_UNIT, "mm/s"))
        )

    @classmethod
    def decode(cls, two: bytes) -> Command:
        """What the firmware makes of two bytes."""
        if len(two) != 2 or 0 in two:
            raise ValueError(f"{two!r} is no command")
        return cls(two[0] * TRAVEL_UNIT, two[1] * SPEED_UNIT)

    def recording_duration(self, timing: Timing) -> float:
        """Length of the record [s]."""
        return timing.before + self.travel / self.speed + timing.after

    def silence(self, timing: Timing) -> float:
        """Time from the command to the first line [s]: the run, then the way back at the same speed."""
        return self.recording_duration(timing) + timing.before + self.travel / self.speed

    def samples(self, timing: Timing) -> int:
        """Samples that the rig has to hold."""
        return int(np.ceil(self.recording_duration(timing) / timing.sample_period))


@dataclass(frozen=True)
class Columns:
    """The four columns as sent, each (samples,): time [us], force [N], flag, voltage [V]."""

    time_us: FloatArray
    force: FloatArray
    flag: FloatArray
    voltage: FloatArray

    def __len__(self) -> int:
        return len(self.time_us)


def render(columns: Columns) -> bytes:
    """The rig's reply, byte for byte."""
    count = b"%d" % len(columns)
    blocks = (
        [b"%d" % value for value in np.rint(columns.time_us).astype(np.int64).tolist()],
        [b"%.*f" % (FORCE_DECIMALS, value) for value in columns.force.tolist()],
        [b"%d" % value for value in np.rint(columns.flag).astype(np.int64).tolist()],
        [b"%.*f" % (VOLTAGE_DECIMALS, value) for value in columns.voltage.tolist()],
    )
    lines = [count]
    for block in blocks:
        lines += block
        lines.append(count)
    return LINE_END.join(lines) + LINE_END


def digest(columns: Columns) -> str:
    """SHA-256 of the reply that says these columns: equal digests, equal data."""
    return hashlib.sha256(render(columns)).hexdigest()


def on_the_grid(
    columns: Columns, *, force_step: float = FORCE_STEP, force_offset: float = FORCE_OFFSET
) -> Columns:
    """The columns as the rig's converters can say them: whole microseconds, whole converter steps."""
    return Columns(
        np.round(columns.time_us),
        np.round(
            np.round((columns.force - force_offset) / force_step) * force_step + force_offset, FORCE_DECIMALS
        ),
        (columns.flag > 0.5).astype(float),
        np.round(np.maximum(np.round(columns.voltage / VOLTAGE_STEP), 0.0) * VOLTAGE_STEP, VOLTAGE_DECIMALS),
    )


def _byte(what: str, value: float, unit: float, shown: str) -> int:
    count = round(value / unit)
    if not 1 <= count <= 255 or abs(value / unit - count) > 1e-6:
        remedy = f"give a multiple of {unit * 1e3:g} {shown} up to {255 * unit * 1e3:g} {shown}"
        raise InputError("plan", f"the rig cannot be told a {what} of {value * 1e3:g} {shown}", remedy)
    return count
