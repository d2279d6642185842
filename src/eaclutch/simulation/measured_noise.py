"""The noise figures of a real bench, from its recordings: what ``BenchNoise`` is set by."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.signal import welch

from eaclutch.records import Bench, FloatArray, LogFile, Recording
from eaclutch.rig.logs import read_log
from eaclutch.rig.published import published
from eaclutch.rig.table import session_of

WINDOW = 0.5  # s of a spectrum: lines 2 Hz apart
STRETCH = 1.0  # s before the voltage, and from STILL after it
STILL = 0.5
FLOOR = 1500.0  # Hz, above which the noise is white
LINES = (50.0, 78.0, 200.0, 300.0, 314.0, 350.0, 400.0, 450.0, 500.0, 550.0)
EDGE = 8  # samples looked at after an edge
REPEATS = 3  # runs of a (session, condition) that make a scatter
SPIKE_RATE = 1000.0  # Hz of the drive at which later edges are far enough apart and many


def measure(logs: Sequence[LogFile], bench: Bench, every: int = 7) -> dict[str, Any]:
    """Figures of a campaign's noise in SI: spectra, pick-up, counts and zeros of one log in ``every`` (whole ones
    only), scatter of repeats of all. Amplitudes are (10 %, median, 90 %) over the logs."""
    whole = [r for r in (read_log(log.path) for log in logs[::every]) if _whole(r)]
    moving, still = (_spectra([_stretch(r, at) for r in whole]) for at in ("moving", "still"))
    return {
        "logs": len(whole),
        "moving": moving,
        "still": still,
        "pickup_n_per_v": _pick_up(whole),
        "force_count_n": float(np.median([np.diff(np.unique(r.force)).min() for r in whole])),
        "voltage_count_v": float(
            np.median([np.diff(np.unique(np.round(r.voltage, 6))).min() for r in whole])
        ),
        "first_force_by_session_n": _by_session(whole, bench),
        "repeats": _scatter(logs, bench),
    }


def _whole(recording: Recording) -> bool:
    steps = np.diff(recording.time)
    driven = np.flatnonzero(recording.flag > 0.5)
    sound = np.isfinite(recording.force).all() and (steps > 0).all() and steps.max() < 1e-3
    return bool(sound and len(driven) and not np.all(recording.force[-50:] == 0))


def _on_off(recording: Recording) -> tuple[int, int]:
    driven = np.flatnonzero(recording.flag > 0.5)
    return int(driven[0]), int(driven[-1]) + 1


def _stretch(recording: Recording, which: str) -> tuple[FloatArray, float]:
    step = float(np.median(np.diff(recording.time)))
    on, off = _on_off(recording)
    count = round(STRETCH / step)
    first = on - count - 10 if which == "moving" else off + round(STILL / step)
    return recording.force[max(first, 0) : max(first, 0) + count], step


def _spectra(stretches: Iterable[tuple[FloatArray, float]]) -> dict[str, Any]:
    white, lines = [], {line: [] for line in LINES}  # type: ignore[var-annotated]
    for force, step in stretches:
        frequency, power = welch(
            force - force.mean(), 1 / step, nperseg=min(round(WINDOW / step), len(force))
        )
        floor = np.mean(power[frequency > FLOOR])  # a median of so few averages is 10 % low
        white.append(np.sqrt(floor / (2 * step)))
        for line in LINES:
            near = np.abs(frequency - line) < 1.6 * frequency[1]
            over = np.sum(power[near] - floor) * frequency[1]
            lines[line].append(np.sqrt(2 * max(over, 0.0)))
    return {
        "white_sd_n": _quantiles(white),
        "line_amplitude_n": {f"{line:g} Hz": _quantiles(found) for line, found in lines.items()},
    }


def _pick_up(recordings: Sequence[Recording]) -> dict[str, list[float]]:
    """Mean force after an edge over the drive voltage, sample by sample from the edge [N/V]."""
    kinds: dict[str, list[FloatArray]] = {"first": [], "rising": [], "falling": []}
    for r in recordings:
        on, _ = _on_off(r)
        high = (r.voltage > 0.5 * r.settings.voltage).astype(int)
        if r.settings.voltage < 100 or not high[on]:
            continue
        kinds["first"].append((r.force[on : on + EDGE] - r.force[on - 20 : on].mean()) / r.settings.voltage)
        if r.settings.frequency == SPIKE_RATE:
            quick = r.force - np.convolve(r.force, np.ones(13) / 13, "same")
            edges = np.diff(high[: on + 25_000])
            for kind, sign in (("rising", 1), ("falling", -1)):
                at = np.flatnonzero(edges == sign)[2:-2] + 1
                mean = quick[at[:, None] + np.arange(EDGE)].mean(axis=0)
                kinds[kind].append(mean / r.settings.voltage)
    return {kind: np.mean(found, axis=0).tolist() if found else [] for kind, found in kinds.items()}


def _by_session(recordings: Sequence[Recording], bench: Bench) -> dict[str, list[float]]:
    """Mean and sd over runs of the first 15 ms of force, before most runs meet the strip."""
    first: dict[str, list[float]] = {}
    for r in recordings:
        first.setdefault(session_of(r.settings.stamp, bench), []).append(float(np.median(r.force[:200])))
    return {name: [float(np.mean(v)), float(np.std(v))] for name, v in sorted(first.items())}


def _scatter(logs: Sequence[LogFile], bench: Bench) -> dict[str, Any]:
    """Robust and plain sd of the logarithm within (session, voltage, frequency, width), by published definitions."""
    rows = []
    for log in logs:
        found, s = published(read_log(log.path)), log.settings
        if found["kept"]:
            key = f"{session_of(s.stamp, bench)} {s.voltage:g} V {s.frequency:g} Hz {s.width * 1e3:g} mm"
            capacity = found["force_max_n"] - found["force_before_voltage_n"]
            rows.append((key, capacity, found["release_90_ms"], found["force_before_voltage_n"]))
    table = pd.DataFrame(rows, columns=["group", "shear_capacity", "release_time_90", "friction_before"])
    table = table[table.groupby("group")["group"].transform("count") >= REPEATS]
    groups = table["group"].nunique()
    out: dict[str, Any] = {"runs": len(table), "groups": groups}
    for name in table.columns[1:]:
        logs_of = np.log(table[name].where(table[name] > 0))
        left = (logs_of - logs_of.groupby(table["group"]).transform("mean")).dropna().to_numpy()
        freedom = np.sqrt(len(left) / max(len(left) - groups, 1))
        out[name] = {
            "sd_log": float(np.sqrt(np.mean(left**2)) * freedom) if len(left) else None,
            "robust_sd_log": float(1.4826 * np.median(np.abs(left)) * freedom) if len(left) else None,
        }
    return out


def _quantiles(values: Sequence[float]) -> list[float]:
    return np.quantile(values, [0.1, 0.5, 0.9]).tolist() if len(values) else []
