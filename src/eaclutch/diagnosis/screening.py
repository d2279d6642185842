"""Which runs count for which observable: what a log shows that the model is not asked to predict is left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from eaclutch.diagnosis.channels import Channel
from eaclutch.records import FloatArray

# Of the load cell's quarter period; a tip that rests and loses all friction at once needs 0.29 and 0.67 of it.
SLIPPING_SHARES = {"release_time_10_s": 0.17, "release_time_50_s": 0.4}
STRAY_SDS = 6.0
LONE_SDS = 10.0  # across sessions: they differ, and a value that much off outweighs what all others say
COUNTED_BLOCKS = ("ramp", "release")  # whose numbers hang on where the force stands against the voltage
SWING_BLOCKS = ("release", "after")  # what a run shows after switch-off
EARLY_SLIP = 0.15  # share of its largest force by which a run may slip too early


def scaled_column(table: pd.DataFrame, channel: Channel) -> tuple[FloatArray, FloatArray]:
    """An observable and its standard uncertainty on the comparison scale, (runs,) each. The zero that runs of a
    session share is a parameter of the fit (diagnosis.readings): its part is left out where the table says it. A run
    that slips while the stage rests has no creep: the slope of its force is that slip."""
    values = pd.to_numeric(table[channel.name], errors="coerce").to_numpy(dtype=float)
    if channel.block == "creep":
        values = np.where(_flagged(table, lambda flag: flag == "slips_at_rest"), np.nan, values)
    sd_name = f"{channel.name}_sd"
    if sd_name in table:
        sd = pd.to_numeric(table[sd_name], errors="coerce").to_numpy(dtype=float)
        if f"{sd_name}_zero_known" in table:
            known = pd.to_numeric(table[f"{sd_name}_zero_known"], errors="coerce").to_numpy(dtype=float)
            sd = np.where(np.isfinite(known), known, sd)
    else:
        sd = np.full(len(values), np.nan)
    if channel.scale == "log":
        # a positive quantity within two sds of zero has no usable logarithm
        values = np.where(values > 2.0 * np.nan_to_num(sd), values, np.nan)
    scaled = channel.forward(values)
    return scaled, np.nan_to_num(channel.forward_sd(values, sd))


def voltage_off_doubt(table: pd.DataFrame) -> FloatArray:
    """Standard uncertainty [s] (runs,) of voltage off where the log leaves open which it was: that of the half-way
    time, which is nearly all of it; 0 elsewhere, NaN for runs without that time."""
    unsure = _flagged(table, lambda flag: flag == "voltage_off_unsure")
    sd = table.get("release_time_50_s_sd", pd.Series(np.nan, table.index)).to_numpy(float)
    return np.where(unsure | ~np.isfinite(sd), sd, 0.0)


def zero_unknown(table: pd.DataFrame) -> np.ndarray:
    """Runs (runs,) that do not show the load cell's zero: their forces still hold it (contract: observables)."""
    return _flagged(table, lambda flag: flag == "no_zero")


def reckoned(table: pd.DataFrame) -> np.ndarray:
    """Runs (runs,) whose times may be wrong by milliseconds: their force lost lines and was moved back by what its
    events tell, by some lines too many or too few where those were lost in several small pieces; or their voltage did,
    and its end was not seen."""
    return _flagged(table, lambda flag: flag.startswith("force_realigned") or flag == "voltage_lines_lost")


def _flagged(table: pd.DataFrame, which: Callable[[str], bool]) -> np.ndarray:
    if "flags" not in table:
        return np.zeros(len(table), dtype=bool)
    return np.array([any(map(which, str(flags).split(";"))) for flags in table["flags"]], dtype=bool)


def slips_at_switch_off(table: pd.DataFrame, quarter_swing: float) -> np.ndarray:
    """Runs (runs,) that were already slipping when the voltage fell: a tenth or half of the force gone in a small part
    of the time that the load cell needs from rest. The model starts from rest, so their release does not count."""
    slips = np.zeros(len(table), dtype=bool)
    for name, share in SLIPPING_SHARES.items():
        if name in table:
            time = pd.to_numeric(table[name], errors="coerce").to_numpy(dtype=float)
            slips |= time < share * quarter_swing
    return slips


def far_from_its_repeats(
    channel: Channel,
    compared: Sequence[FloatArray],
    sd: FloatArray,
    conditions: np.ndarray,
    sessions: np.ndarray,
    groups: np.ndarray,
) -> np.ndarray:
    """Runs (runs,) whose value is left out: far from the repeats in its session, once a first fit has explained what
    differs from run to run, or from all runs of its condition. That is no reason where a tip that sticks a swing
    earlier, by the force it starts from, ends its fall much earlier.

    compared: values (runs,) as they are and, where there is a first fit, less what that explains. groups: labels of
    (condition, session)."""
    apart = np.zeros(len(sd), dtype=bool)
    for explained in compared[1:]:
        apart |= stray(explained, sd, groups)
    if channel.block in SWING_BLOCKS:
        return apart
    return apart | lone([np.where(apart, np.nan, each) for each in compared], sd, conditions, sessions)


def stray(residual: FloatArray, sd: FloatArray, groups: np.ndarray) -> np.ndarray:
    """Runs that stand far from their own repeats (three or more, so that the odd one out can be told)."""
    apart = np.full(len(residual), np.nan)
    for label in np.unique(groups):
        rows = np.flatnonzero((groups == label) & np.isfinite(residual))
        if len(rows) >= 3:
            apart[rows] = residual[rows] - np.median(residual[rows])
    known = np.isfinite(apart)
    if np.count_nonzero(known) < 10:
        return np.zeros(len(residual), dtype=bool)
    return known & (np.abs(apart) > STRAY_SDS * np.hypot(_spread(np.abs(apart[known])), sd))


def lone(
    shown: Sequence[FloatArray], sd: FloatArray, conditions: np.ndarray, sessions: np.ndarray
) -> np.ndarray:
    """Runs (runs,) that no other run of their condition, of whatever session, comes near, however their values (runs,)
    are ``shown``, where two or more others can tell. Sessions are levelled. Where several of a condition stand alone
    nobody knows which is odd, and where several of a session do, the session differs."""
    far = np.full(len(sd), np.inf)
    for values in shown:
        level, nearest, away = values.copy(), np.zeros(len(sd)), np.full(len(sd), np.nan)
        for rows in _rows_of(sessions, values):
            level[rows] -= np.median(level[rows])
        for rows in _rows_of(conditions, values):
            for i in rows if len(rows) >= 3 else ():
                others = level[rows[rows != i]]
                nearest[i], away[i] = np.min(np.abs(level[i] - others)), abs(level[i] - np.median(others))
        known = away[np.isfinite(away)]
        if len(known) < 10:
            return np.zeros(len(sd), dtype=bool)
        far = np.minimum(far, nearest / np.maximum(np.hypot(_spread(known), sd), 1e-300))
    odd = far > LONE_SDS
    crowded = [
        rows for labels in (conditions, sessions) for rows in _rows_of(labels, odd) if odd[rows].sum() > 1
    ]
    odd[np.concatenate([*crowded, np.array([], dtype=int)])] = False
    return odd


def _rows_of(labels: np.ndarray, values: FloatArray) -> list[np.ndarray]:
    """The rows with a value of each label that has one."""
    found = (np.flatnonzero((labels == label) & np.isfinite(values)) for label in np.unique(labels))
    return [rows for rows in found if len(rows)]


def _spread(away: FloatArray) -> float:
    """Robust sd of runs from their distances to a median; those that are the median say nothing, 0 if all are."""
    return 1.4826 * float(np.median(away[away > 0])) if np.any(away > 0) else 0.0


def misplaced(
    residual: FloatArray, sd: FloatArray, conditions: np.ndarray, doubtful: np.ndarray
) -> np.ndarray:
    """The ``doubtful`` runs (runs,) that no other run of their condition, of whatever session, confirms: they stand far
    from those (which scatter between sessions as well, so their own spread is the measure), or there are none."""
    whole = np.isfinite(residual) & ~doubtful
    away = np.full(len(residual), np.inf)
    apart = []
    for label in np.unique(conditions):
        rows = np.flatnonzero((conditions == label) & np.isfinite(residual))
        others = rows[whole[rows]]
        if len(others):
            away[rows] = np.abs(residual[rows] - np.median(residual[others]))
        if len(others) > 1:
            apart.append(away[others])
    spread = _spread(np.concatenate(apart)) if apart else 0.0
    return doubtful & np.isfinite(residual) & (away > STRAY_SDS * np.hypot(spread, sd))


def wrongly_reckoned(
    table: pd.DataFrame, conditions: Sequence[str], channels: Sequence[Channel], explained: FloatArray | None
) -> np.ndarray:
    """Runs (runs,) whose times were reckoned and that are contradicted by some of what they show, once a first fit has
    ``explained`` (channels, runs) what differs from run to run. That fit is made without any of them, for one that is
    milliseconds off would bend it."""
    doubtful, labels = reckoned(table), np.array(conditions, dtype=str)
    if explained is None:
        return doubtful
    wrong = np.zeros(len(table), dtype=bool)
    for i, channel in enumerate(channels):
        if doubtful.any() and channel.block in COUNTED_BLOCKS:
            scaled, sd = scaled_column(table, channel)
            wrong |= misplaced(scaled - explained[i], sd, labels, doubtful)
    return wrong


def reaches(table: pd.DataFrame, channel: Channel, ramp_rate: float) -> np.ndarray:
    """Runs whose ramp is still a ramp at the end of the channel's window: even a first slip that comes early, static
    friction scatters, lies above the force that the stage reaches by then."""
    if channel.window_end is None or "shear_capacity_n" not in table:
        return np.ones(len(table), dtype=bool)
    capacity = pd.to_numeric(table["shear_capacity_n"], errors="coerce").to_numpy(dtype=float)
    before = np.zeros(len(table))
    if "friction_before_n" in table:
        before = np.nan_to_num(
            pd.to_numeric(table["friction_before_n"], errors="coerce").to_numpy(dtype=float)
        )
    earliest = capacity - EARLY_SLIP * (capacity + np.abs(before))
    return earliest > 1.1 * ramp_rate * channel.window_end
