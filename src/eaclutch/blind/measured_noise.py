"""What disturbs published logs: the statistics behind ``readout`` and ``rawlogs``, session by session."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from eaclutch.records import FloatArray, InputError, Recording
from eaclutch.rig.logs import read_log

RATE = 12_800  # samples a second
BANDS = {  # Hz
    "mains_50_hz": (48, 53),
    "mains_100_hz": (98, 103),
    "mains_150_hz": (147, 153),
    "line_200_hz": (195, 205),
    "line_300_hz": (297, 305),
    "line_313_hz": (308, 320),
    "line_400_hz": (390, 410),
    "line_600_hz": (585, 610),
}
LOST = 20  # zeros at a column's end from which lines were lost


def measure_noise(paths: Iterable[Path]) -> dict[str, Any]:
    """Noise by session (date of the log's name) from the second before voltage on, and shares of lost lines.

    Returns {session: {runs, white_sd_n, start_mean_n: [median, sd], <band>_n: [median, sd], force_lost_share,
    voltage_lost_too_share, lost_lines_median}}. Raises InputError without a log.
    """
    rows: dict[str, list[dict[str, float]]] = {}
    for path in sorted(paths):
        recording = read_log(path)
        rows.setdefault(recording.settings.stamp.strftime("%Y-%m-%d"), []).append(_measure(recording))
    if not rows:
        raise InputError("tensile", "holds no log", "name the folder of a campaign")
    return {session: _summary(found) for session, found in sorted(rows.items())}


def _measure(recording: Recording) -> dict[str, float]:
    force_lost, voltage_lost = zeros_at_end(recording.force), zeros_at_end(recording.voltage)
    row = {"force_lost": float(force_lost), "voltage_lost": float(voltage_lost)}
    on = int(np.argmax(recording.flag > 0.5))
    quiet = recording.force[on - RATE : on]
    if force_lost > LOST or on < RATE or not np.isfinite(quiet).all():
        return row
    row["start"] = float(recording.force[:200].mean())
    row["white"] = float(1.4826 * np.median(np.abs(np.diff(quiet))) / np.sqrt(2))
    place = np.arange(RATE)
    spectrum = np.abs(np.fft.rfft(quiet - np.polyval(np.polyfit(place, quiet, 1), place))) * 2 / RATE
    return row | {name: float(spectrum[low:high].max()) for name, (low, high) in BANDS.items()}


def zeros_at_end(column: FloatArray) -> int:
    """How many exact zeros a column ends in."""
    filled = np.flatnonzero(column != 0)
    return len(column) - 1 - int(filled[-1]) if len(filled) else len(column)


def _summary(rows: list[dict[str, float]]) -> dict[str, Any]:
    lost = [row["force_lost"] for row in rows if row["force_lost"] > LOST]
    both = [row for row in rows if row["force_lost"] > LOST and row["voltage_lost"] > LOST]

    def of(name: str) -> list[float]:
        values = [row[name] for row in rows if name in row]
        return [float(np.median(values)), float(np.std(values))] if values else []

    return {
        "runs": len(rows),
        "white_sd_n": of("white"),
        "start_mean_n": of("start"),
        **{f"{name}_n": of(name) for name in BANDS},
        "force_lost_share": len(lost) / len(rows),
        "voltage_lost_too_share": len(both) / len(lost) if lost else 0.0,
        "lost_lines_median": float(np.median(lost)) if lost else 0.0,
    }
