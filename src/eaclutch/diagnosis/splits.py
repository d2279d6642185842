"""Two-way splits of a campaign's runs by its settings, and which settings cannot be told apart in its design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from eaclutch.diagnosis.data import DataVector
from eaclutch.records import FloatArray

FEW_LEVELS = 6  # of a factor that is taken level by level; a level a run would explain anything


@dataclass(frozen=True)
class Split:
    """A factor cut in two: ``level`` names the side, ``member`` (run entries,) its weight in 0..1."""

    factor: str
    level: str
    member: FloatArray


def splits_of(data: DataVector) -> list[Split]:
    """Every two-way split of every factor over the run entries; member (run entries,)."""
    n = data.run_entries
    found = [Split("all", "all", np.ones(n))]
    for factor, entry in settings_of(data).items():
        if factor == "session":
            continue
        for cut in _cuts(entry):
            low = (entry <= cut).astype(float)
            found += [Split(factor, f"<={cut:.3g}", low), Split(factor, f">{cut:.3g}", 1.0 - low)]
    sessions = data.session[:n]
    if len(set(sessions)) > 1:
        found += [
            Split("session", name, (sessions == name).astype(float)) for name in dict.fromkeys(sessions)
        ]
    return found


def settings_of(data: DataVector) -> dict[str, FloatArray]:
    """{factor: its value at every run entry}; a session's is its number. A time at rest below a millisecond, a few
    samples, is none."""
    runs, n = data.conditions, data.run_entries
    weights = _entry_average(data)
    arrays = {
        "voltage_v": runs.voltage,
        "frequency_hz": runs.frequency,
        "width_mm": runs.width * 1e3,
        "thickness_mm": runs.thickness * 1e3,
        "preload_n": data.preload,
        "dwell_s": np.round(runs.dwell, 3),
        "run_order": runs.run_order,
    }
    found = {factor: _exact(weights @ np.nan_to_num(values)) for factor, values in arrays.items()}
    session = np.unique(np.array(data.session[:n], dtype=str), return_inverse=True)[1]
    return found | {"session": session.astype(float)}


def _exact(average: FloatArray) -> FloatArray:
    """Averages at nine digits: the mean of equal settings is that setting, not a bit beside it."""
    return np.array([float(f"{value:.9g}") for value in average])


def _cuts(entry: FloatArray) -> list[float]:
    """At most four cuts between distinct levels, at quantiles of the distinct values."""
    distinct = np.unique(entry)
    if len(distinct) < 2:
        return []
    if len(distinct) <= 5:
        return [float(v) for v in distinct[:-1]]
    return sorted(
        {float(v) for v in np.quantile(distinct, [0.2, 0.4, 0.6, 0.8], method="lower")} - {distinct[-1]}
    )


def _entry_average(data: DataVector) -> FloatArray:
    """(run entries, runs): weights that average a run-level setting into an entry."""
    n_runs = len(data.conditions)
    folded = data.average.tocoo()
    out = np.zeros((data.run_entries, n_runs))
    out[folded.row, folded.col % n_runs] = folded.data
    return out


def confounded(split: Split, settings: Mapping[str, FloatArray], least: float) -> list[str]:
    """Factors whose values say which side of the split a run is on in this campaign's design (``least`` of its variance
    or more): by their levels where they are few, else by the best cut between them. Sessions have no order, and are
    taken one by one as long as each holds two different settings on the average."""
    if split.factor == "all" or np.std(split.member) == 0:
        return []
    designs = len(np.unique(np.column_stack(list(settings.values())), axis=0))
    few = {"session": max(FEW_LEVELS, designs // 2)}
    return sorted(
        factor
        for factor, values in settings.items()
        if factor != split.factor and _told_by(split.member, values, few.get(factor, FEW_LEVELS)) >= least
    )


def _told_by(member: FloatArray, values: FloatArray, few: int) -> float:
    """Share of the variance of ``member`` (entries,) that a factor's ``values`` (entries,) explain, by level up to
    ``few`` of them."""
    levels, index = np.unique(values, return_inverse=True)
    if len(levels) < 2:
        return 0.0
    sides = [(values <= cut).astype(int) for cut in levels[:-1]] if len(levels) > few else [index]
    variance, best = float(np.var(member)), 0.0
    for side in sides:
        count = np.bincount(side)
        mean = np.bincount(side, weights=member) / np.maximum(count, 1)
        best = max(best, float(np.var(mean[side])) / variance)
    return best
