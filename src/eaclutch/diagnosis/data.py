"""The data vector: every usable observable averaged over (condition, session), plus the bench channels.

An *entry* is one mean: of a channel over the repeats of a condition in a session, or of a bench channel
(capacitance, permittivity, bursts of the load cell) at one setting.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from scipy import sparse

from eaclutch.diagnosis.bench_channels import BenchEntries
from eaclutch.diagnosis.channels import FORCE_SCALE, Channel
from eaclutch.diagnosis.repeatability import PRELOAD_EDGES, RepeatVariance, pooled_variance, shrunk_variance
from eaclutch.records import FloatArray, RunConditions

IntArray = np.ndarray
SWING_BLOCKS = ("release", "ringdown", "ringdown_damping", "after")  # what a run shows after switch-off
SLIPPING_SHARE = 0.4  # of the load cell's quarter period
STRAY_SDS = 6.0
SESSION_DOF = 2.0  # what the pooled repeat variance weighs against a session's own
EARLY_SLIP = 0.15  # share of its largest force by which a run may slip too early


@dataclass(frozen=True)
class DataVector:
    """What the hypotheses compete to explain; arrays are (entries,) unless stated.

    values, noise_sd: on the comparison scale. block, channel, condition, session: names (condition and
    session empty for bench entries). offset: label of the random offset an entry shares with others of its
    block (session, width, source). features (entries, features): scaled settings for smooth terms; entries of
    different ``family`` (run, capacitance, ...) never share a smooth term.
    average: sparse (run entries, channels x runs) matrix that turns run-level predictions into entries.
    """

    conditions: RunConditions
    channels: tuple[Channel, ...]
    values: FloatArray
    noise_sd: FloatArray
    count: FloatArray
    block: np.ndarray
    channel: np.ndarray
    condition: np.ndarray
    session: np.ndarray
    offset: np.ndarray
    family: np.ndarray
    features: FloatArray
    friction: FloatArray  # before the voltage, in units of the baseline shift's scale; 0 of bench entries
    average: sparse.csr_matrix
    bench: BenchEntries
    repeats: Mapping[str, RepeatVariance]
    zero_unknown: np.ndarray  # (runs,) whether the load cell's zero is still in the run's forces
    groups: np.ndarray  # (runs,) label of each run's (condition, session)
    entry_group: np.ndarray  # (run entries,) the same of each entry
    run_values: FloatArray = field(repr=False)  # (channels, runs), comparison scale, NaN where unusable

    def __len__(self) -> int:
        return len(self.values)

    @property
    def run_entries(self) -> int:
        """How many of the entries (the first ones) are run entries."""
        return self.average.shape[0]


def build(
    table: pd.DataFrame,
    conditions: RunConditions,
    bench: BenchEntries,
    channels: Sequence[Channel],
    thresholds: Mapping[str, Any],
    ramp_rate: float,
    quarter_swing: float,
    explained: FloatArray | None = None,
    carried: FloatArray | None = None,
) -> DataVector:
    """Collect the entries.

    table: runs.csv's rows for exactly ``conditions`` (same order). channels: what to compare; those without a
    usable run are left out. ramp_rate [N/s], quarter_swing [s]: the load train's nominal ones, which say how far
    a ramp gets and how fast a release from rest can be.
    explained (channels, runs): predictions whose variation between repeats (the force at switch-off differs
    from run to run) is taken off before the scatter is measured, where that makes it smaller. carried: standard
    uncertainty of these predictions (channels, runs) from the measured forces that they start from.
    """
    groups = _labels([f"{c}|{s}" for c, s in zip(conditions.condition, conditions.session, strict=True)])
    bins = np.digitize(estimated_preload(table, conditions), PRELOAD_EDGES)
    slipping = slips_at_switch_off(table, quarter_swing)
    entries, values, repeats = [], [], {}
    kept: list[Any] = []
    for i, channel in enumerate(channels):
        scaled, sd = scaled_column(table, channel)
        if carried is not None:
            sd = np.hypot(sd, carried[i])
        scaled = np.where(_reaches(table, channel, ramp_rate), scaled, np.nan)
        if channel.block in SWING_BLOCKS:
            scaled = np.where(slipping, np.nan, scaled)
        if explained is not None:
            scaled = np.where(_stray(scaled - explained[i], sd, groups), np.nan, scaled)
        if np.count_nonzero(np.isfinite(scaled)) == 0:
            continue
        repeat, spread = pooled_variance(scaled, conditions.friction_before, groups, bins), scaled
        if explained is not None:
            other = pooled_variance(scaled - explained[i], conditions.friction_before, groups, bins)
            if other.variance < repeat.variance:
                repeat, spread = other, scaled - explained[i]
        variance = _run_variance(repeat, sd, np.isfinite(scaled), thresholds, channel.block)
        variance = variance * _session_share(spread, repeat, conditions, groups, bins)
        entries += _entries(scaled, variance, groups, len(kept))
        kept.append(channel)
        repeats[channel.name] = repeat
        values.append(scaled)
    run_values = np.array(values).reshape(len(kept), len(conditions))
    return _assemble(conditions, tuple(kept), entries, bench, repeats, groups, run_values, thresholds, table)


def zero_unknown(table: pd.DataFrame) -> np.ndarray:
    """Runs (runs,) that do not show the load cell's zero: their forces still hold it (contract: observables)."""
    if "flags" not in table:
        return np.zeros(len(table), dtype=bool)
    return np.array(["no_zero" in str(flags).split(";") for flags in table["flags"]], dtype=bool)


def slips_at_switch_off(table: pd.DataFrame, quarter_swing: float) -> np.ndarray:
    """Runs (runs,) that were already slipping when the voltage fell: half of the force gone in a small part of
    the time that the load cell needs from rest. The model starts from rest, so their release does not count."""
    if "release_time_50_s" not in table:
        return np.zeros(len(table), dtype=bool)
    half = pd.to_numeric(table["release_time_50_s"], errors="coerce").to_numpy(dtype=float)
    return half < SLIPPING_SHARE * quarter_swing


def _stray(residual: FloatArray, sd: FloatArray, groups: IntArray) -> np.ndarray:
    """Runs that stand far from their own repeats (three or more, so that the odd one out can be told)."""
    apart = np.full(len(residual), np.nan)
    for label in np.unique(groups):
        rows = np.flatnonzero((groups == label) & np.isfinite(residual))
        if len(rows) >= 3:
            apart[rows] = residual[rows] - np.median(residual[rows])
    known = np.isfinite(apart)
    if np.count_nonzero(known) < 10:
        return np.zeros(len(residual), dtype=bool)
    spread = (
        1.4826 * float(np.median(np.abs(apart[known & (apart != 0)]))) if np.any(apart[known] != 0) else 0.0
    )
    return known & (np.abs(apart) > STRAY_SDS * np.hypot(spread, sd))


def _reaches(table: pd.DataFrame, channel: Channel, ramp_rate: float) -> np.ndarray:
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


def scaled_column(table: pd.DataFrame, channel: Channel) -> tuple[FloatArray, FloatArray]:
    """An observable and its standard uncertainty on the comparison scale, (runs,) each."""
    values = pd.to_numeric(table[channel.name], errors="coerce").to_numpy(dtype=float)
    sd_name = f"{channel.name}_sd"
    if sd_name in table:
        sd = pd.to_numeric(table[sd_name], errors="coerce").to_numpy(dtype=float)
    else:
        sd = np.full(len(values), np.nan)
    if channel.scale == "log":
        # a positive quantity within two sds of zero has no usable logarithm
        values = np.where(values > 2.0 * np.nan_to_num(sd), values, np.nan)
    scaled = channel.forward(values)
    return scaled, np.nan_to_num(channel.forward_sd(values, sd))


def _run_variance(
    repeat: RepeatVariance, sd: FloatArray, usable: np.ndarray, thresholds: Mapping[str, Any], block: str
) -> FloatArray:
    """Variance of a single run (runs,): each run's own extractor variance plus what repeats scatter beyond it."""
    own = sd**2
    typical = float(np.median(own[usable]))
    prior = typical + thresholds["repeat_sd"].get(block, 0.02) ** 2
    total = shrunk_variance(repeat, prior, thresholds["repeat_prior_dof"])
    return np.maximum(total - typical, 0.1 * total) + own


def _session_share(
    spread: FloatArray, pooled: RepeatVariance, conditions: RunConditions, groups: IntArray, bins: IntArray
) -> FloatArray:
    """Each run's session's variance over the pooled one, (runs,): what shakes a bench on one day, a line of mains or
    a pump, leaves it alone on the next. Drawn to the pooled one where a session has few repeats."""
    share = np.ones(len(conditions))
    if pooled.dof == 0 or not pooled.variance > 0:
        return share
    sessions = np.array(conditions.session, dtype=object)
    for name in dict.fromkeys(conditions.session):
        rows = sessions == name
        own = pooled_variance(np.where(rows, spread, np.nan), conditions.friction_before, groups, bins)
        share[rows] = shrunk_variance(own, pooled.variance, SESSION_DOF) / pooled.variance
    return share


def _entries(scaled: FloatArray, variance: FloatArray, groups: IntArray, channel: int) -> list[tuple]:
    """(channel, rows, weights, mean, sd of the mean) of every group with a usable run."""
    found = []
    for label in np.unique(groups):
        rows = np.flatnonzero((groups == label) & np.isfinite(scaled))
        if len(rows):
            weights = 1.0 / variance[rows]
            total = float(weights.sum())
            weights = weights / total
            found.append((channel, rows, weights, float(weights @ scaled[rows]), total**-0.5))
    return found


def _assemble(
    conditions: RunConditions,
    channels: tuple[Channel, ...],
    entries: list[tuple],
    bench: BenchEntries,
    repeats: dict[str, RepeatVariance],
    groups: IntArray,
    run_values: FloatArray,
    thresholds: Mapping[str, Any],
    table: pd.DataFrame,
) -> DataVector:
    n_runs, n = len(conditions), len(entries)
    average = sparse.lil_matrix((n, len(channels) * n_runs))
    for i, (channel, rows, weights, _, _) in enumerate(entries):
        average[i, channel * n_runs + rows] = weights
    settings = run_features(conditions, estimated_preload(table, conditions), thresholds["length_scales"])
    features = np.array([settings[rows].mean(axis=0) for _, rows, *_ in entries]).reshape(
        n, settings.shape[1]
    )
    before = np.maximum(np.nan_to_num(conditions.friction_before), 0.0) / FORCE_SCALE
    friction = np.array([before[rows].mean() for _, rows, *_ in entries])
    first = [rows[0] for _, rows, *_ in entries]
    wide = max(features.shape[1], bench.features.shape[1])

    def join(runs: list, others: np.ndarray) -> np.ndarray:
        return np.concatenate([np.array(runs, dtype=object), others.astype(object)])

    empty = np.array([""] * len(bench.values), dtype=object)
    return DataVector(
        conditions,
        channels,
        np.concatenate([[e[3] for e in entries], bench.values]),
        np.concatenate([[e[4] for e in entries], bench.noise_sd]),
        np.concatenate([[float(len(e[1])) for e in entries], np.ones(len(bench.values))]),
        join([channels[e[0]].block for e in entries], bench.block),
        join([channels[e[0]].name for e in entries], bench.block),
        join([conditions.condition[i] for i in first], empty),
        join([conditions.session[i] for i in first], empty),
        join([conditions.session[i] for i in first], bench.offset),
        join(["run"] * n, bench.block),
        np.concatenate([_widen(features, wide), _widen(bench.features, wide)]),
        np.concatenate([friction, np.zeros(len(bench.values))]),
        average.tocsr(),
        bench,
        repeats,
        zero_unknown(table),
        groups,
        groups[np.array(first, dtype=int)],
        run_values,
    )


def run_features(conditions: RunConditions, preload: FloatArray, scales: Mapping[str, float]) -> FloatArray:
    """Settings of each run in units of the smooth terms' length scales, (runs, 5)."""
    order = conditions.run_order / max(1.0, float(np.max(conditions.run_order, initial=0.0)))
    return np.column_stack(
        [
            np.log10(conditions.frequency) / scales["log10_frequency"],
            conditions.voltage / scales["voltage"],
            np.log(conditions.width) / scales["log_width"],
            np.log(0.05 + np.maximum(preload, 0.0)) / scales["log_preload"],
            order / scales["order"],
        ]
    )


def estimated_preload(table: pd.DataFrame, conditions: RunConditions) -> FloatArray:
    """Estimated preload [N] (runs,); the friction before over the coefficients' sum where runs.csv has none."""
    estimate = conditions.friction_before / 0.33
    if "preload_n" in table:
        read = pd.to_numeric(table["preload_n"], errors="coerce").to_numpy(dtype=float)
        estimate = np.where(np.isfinite(read), read, estimate)
    return np.nan_to_num(estimate)


def _labels(names: Sequence[str]) -> IntArray:
    return np.unique(np.array(names, dtype=object).astype(str), return_inverse=True)[1]


def _widen(features: FloatArray, columns: int) -> FloatArray:
    return np.pad(features, ((0, 0), (0, columns - features.shape[1])))
