"""The published definitions of engagement, release and forces, on the columns as logged.

Rauf & Follmer, Extreme Mechanics Letters 79 (2025) 102382, and the authors' released processing. Kept beside the
observables so that the paper's numbers can be reproduced; nothing else is built on them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from scipy.signal import butter, sosfiltfilt

from eaclutch.records import FloatArray, Recording
from eaclutch.rig.events import SENSED_HIGH

RATE = 12_800.0  # Hz, nominal; all indices below count its samples
HALF_MS, TWO_MS, FIVE_MS, TEN_MS, TWENTY_MS, TENTH_S, HALF_S = 6, 25, 64, 128, 256, 1280, 6400
R_SQUARED = 0.8
LATEST_ENGAGEMENT_US, LATEST_RELEASE_MS = 50.0, 10.0

COLUMNS = (
    "run", "engagement_us", "release_90_ms", "release_10_ms", "force_at_switch_off_n", "force_before_voltage_n",
    "force_max_n", "kept", "reason",
)  # fmt: skip


@dataclass(frozen=True)
class _Run:
    time: FloatArray  # us
    force: FloatArray  # N
    on: int
    off: int


def published(recording: Recording) -> dict[str, Any]:
    """One row of runs_published.csv for a recording as logged; numbers are NaN where a definition gives none.

    ``kept`` is False where the published rules leave the run out, and ``reason`` says which one.
    """
    row: dict[str, Any] = dict.fromkeys(COLUMNS, math.nan)
    row |= {"run": recording.settings.run, "kept": False, "reason": ""}
    try:
        run = _clean(recording)
        release, forces = _release(run)
        row |= forces | release
        row["engagement_us"] = _engagement(run)
        if row["engagement_us"] > LATEST_ENGAGEMENT_US:
            raise _LeftOut("late_engagement")
        if row["release_90_ms"] > LATEST_RELEASE_MS:
            raise _LeftOut("late_release")
        row["kept"] = True
    except _LeftOut as reason:
        row["reason"] = str(reason)
    return row


class _LeftOut(Exception):
    """The published rules leave the run out; the message is the reason."""


def _clean(recording: Recording) -> _Run:
    time = recording.time * 1e6
    columns = np.stack([np.round(time, 3), recording.force, recording.flag, recording.voltage])
    columns = columns[:, np.isfinite(columns).all(axis=0)]
    columns = _close_time_hole(columns)
    columns = columns[:, (columns[1] <= 50.0) & (columns[0] <= 1e8)]
    steps = np.diff(columns[0], prepend=columns[0, 0] - 78.0)
    time, force, flag, voltage = columns[:, (steps > 0) & (steps < 1000.0)]
    driven, sensed = np.flatnonzero(flag > 0.5), np.flatnonzero(voltage > SENSED_HIGH)
    if len(driven) == 0 or len(sensed) == 0:
        raise _LeftOut("no_voltage")
    on, off = max(driven[0], sensed[0]), max(driven[-1], sensed[-1]) + 1
    if on < HALF_S or off + TENTH_S + TEN_MS > len(time):
        raise _LeftOut("no_release_recorded")
    return _Run(time, force, int(on), int(off))


def _close_time_hole(columns: FloatArray) -> FloatArray:
    """Where time ends in zeros: what follows the jump belongs at the end, and the hole is interpolated."""
    time = columns[0]
    tail = len(time) - 1 - int(np.flatnonzero(time > 0)[-1]) if (time > 0).any() else 0
    jumps = np.flatnonzero(np.diff(time[: len(time) - tail]) >= 1000.0)
    if tail == 0 or len(jumps) == 0:
        return columns
    jump = int(jumps[0])
    mended = time.copy()
    mended[jump + 1 + tail :] = time[jump + 1 : len(time) - tail]
    hole = np.arange(jump + 1, jump + 1 + tail)
    mended[hole] = np.interp(hole, [jump, jump + 1 + tail], [time[jump], time[jump + 1]])
    return np.concatenate([mended[None], columns[1:]])


@lru_cache(maxsize=8)
def _filter(order: int, band: tuple[float, ...], kind: Literal["lowpass", "bandstop"]) -> FloatArray:
    edges: Any = band if len(band) > 1 else band[0]
    return butter(order, edges, kind, fs=RATE, output="sos")


def _release(run: _Run) -> tuple[dict[str, float], dict[str, float]]:
    force, off = run.force, run.off
    final = force[off + TEN_MS : off + TEN_MS + TENTH_S].mean()
    highest = force[off : off + TENTH_S].max()
    forces = {
        "force_at_switch_off_n": float(highest),
        "force_before_voltage_n": float(force[run.on - FIVE_MS : run.on].mean()),
        "force_max_n": float(force.max()),
    }
    smooth = sosfiltfilt(_filter(2, (250.0,), "lowpass"), force)
    above = np.flatnonzero(smooth > final + 0.3 * (smooth.max() - final))
    if len(above) and above[-1] < off:
        raise _LeftOut("released_early")
    times = {}
    for share, name in ((0.1, "release_90_ms"), (0.9, "release_10_ms")):
        below = np.flatnonzero(force[off + 1 :] < final + share * (highest - final))
        if len(below) == 0:
            raise _LeftOut("never_released")
        times[name] = float(run.time[off + 1 + below[0]] - run.time[off]) * 1e-3
    return times, forces


def _engagement(run: _Run) -> float:
    on = run.on
    quiet = run.force[on - HALF_S : on - TWO_MS]
    limit = quiet.mean() + 10.0 * quiet.std()
    if (run.force[on * 2 // 3 : on] > limit).any():
        raise _LeftOut("force_before_voltage")
    smooth = sosfiltfilt(_filter(5, (48.0, 52.0), "bandstop"), run.force)
    smooth = sosfiltfilt(_filter(3, (250.0,), "lowpass"), smooth)
    baseline = smooth[on - TEN_MS : on - TWO_MS].mean()
    window = slice(on + HALF_MS, on + TWENTY_MS)
    crossings = _line_crossings(run.time[window] - run.time[on], smooth[window] - baseline)
    positive = crossings[crossings >= 0]
    if len(positive):
        return float(positive.min())
    if len(crossings) and crossings.max() > -2000.0:
        return 0.0
    raise _LeftOut("no_engagement")


def _line_crossings(x: FloatArray, y: FloatArray) -> FloatArray:
    """Where the least-squares lines through the first n samples, n growing, cross zero; those that fit well [us]."""
    n = np.arange(1, len(x) + 1)
    sums = [np.cumsum(values) for values in (x, y, x * x, x * y, y * y)]
    sx, sy, sxx, sxy, syy = (values[TWO_MS - HALF_MS - 1 :] for values in sums)
    n = n[TWO_MS - HALF_MS - 1 :]
    cxx, cxy, cyy = sxx - sx * sx / n, sxy - sx * sy / n, syy - sy * sy / n
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = cxy / cxx
        crossing = -(sy - slope * sx) / n / slope
        fits = cxy**2 / (cxx * cyy) >= R_SQUARED
    return crossing[fits & np.isfinite(crossing)]
