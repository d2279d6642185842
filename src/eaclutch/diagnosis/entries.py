"""Collects the entries of the data vector from a campaign's runs and bench channels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy import sparse

from eaclutch.diagnosis.bench_channels import BenchEntries
from eaclutch.diagnosis.channels import Channel
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.repeatability import (
    instead,
    pooled_variance,
    preload_bins,
    run_variance,
    session_share,
)
from eaclutch.diagnosis.run_settings import run_features
from eaclutch.diagnosis.screening import (
    COUNTED_BLOCKS,
    SWING_BLOCKS,
    far_from_its_repeats,
    reaches,
    scaled_column,
    slips_at_switch_off,
    voltage_off_doubt,
    wrongly_reckoned,
    zero_unknown,
)
from eaclutch.diagnosis.switch_timing import FALL_SD, shared_edge_sd
from eaclutch.records import FloatArray, RunConditions

IntArray = np.ndarray
TIMED_BLOCK = "release"  # its times count from voltage off


def build(
    table: pd.DataFrame,
    conditions: RunConditions,
    bench: BenchEntries,
    channels: Sequence[Channel],
    thresholds: Mapping[str, Any],
    preload: FloatArray,
    ramp_rate: float,
    quarter_swing: float,
    explained: FloatArray | None = None,
    carried: FloatArray | None = None,
) -> DataVector:
    """Collect the entries.

    table: runs.csv's rows for exactly ``conditions`` (same order). channels: what to compare; those without a
    usable run are left out. preload: (runs,) [N]. ramp_rate [N/s], quarter_swing [s]: the load train's nominal ones,
    which say how far a ramp gets and how fast a release from rest can be.
    explained (channels, runs): predictions whose variation between repeats (the force at switch-off differs
    from run to run) is taken off before the scatter is measured, where that makes it smaller. carried: standard
    uncertainty of these predictions (channels, runs) from the measured forces that they start from.
    """
    groups = _labels([f"{c}|{s}" for c, s in zip(conditions.condition, conditions.session, strict=True)])
    bins = preload_bins(conditions.condition, preload)
    contradicted = wrongly_reckoned(table, conditions.condition, channels, explained)
    slipping = slips_at_switch_off(table, quarter_swing)
    labels, sessions = np.array(conditions.condition, dtype=str), np.array(conditions.session, dtype=str)
    entries, values, odd = [], [], []
    kept: list[Any] = []
    for i, channel in enumerate(channels):
        scaled, sd = scaled_column(table, channel)
        if carried is not None:
            sd = np.hypot(sd, carried[i])
        scaled = np.where(reaches(table, channel, ramp_rate), scaled, np.nan)
        if channel.block in SWING_BLOCKS:
            scaled = np.where(slipping, np.nan, scaled)
        compared = [scaled] if explained is None else [scaled, scaled - explained[i]]
        apart = far_from_its_repeats(channel, compared, sd, labels, sessions, groups)
        odd += [f"{channel.name} of {conditions.run[j]}" for j in np.flatnonzero(apart)]
        if channel.block in COUNTED_BLOCKS:
            apart |= contradicted
        compared = [np.where(apart, np.nan, each) for each in compared]
        scaled = compared[0]
        if np.count_nonzero(np.isfinite(scaled)) == 0:
            continue
        repeat, spread = pooled_variance(scaled, conditions.friction_before, groups, bins), scaled
        if explained is not None:
            other = pooled_variance(compared[1], conditions.friction_before, groups, bins)
            if other.variance < repeat.variance:
                repeat, spread = other, compared[1]
        across = instead(repeat, compared, conditions)
        variance = run_variance(repeat, across, sd, np.isfinite(scaled), thresholds, channel.block)
        variance = variance * session_share(spread, repeat, conditions, groups, bins)
        entries += _entries(scaled, variance, groups, len(kept))
        kept.append(channel)
        values.append(scaled)
    run_values = np.array(values).reshape(len(kept), len(conditions))
    return _assemble(
        conditions, tuple(kept), entries, bench, groups, run_values, thresholds, table, preload, odd
    )


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
    groups: IntArray,
    run_values: FloatArray,
    thresholds: Mapping[str, Any],
    table: pd.DataFrame,
    preload: FloatArray,
    odd: Sequence[str],
) -> DataVector:
    n_runs, n = len(conditions), len(entries)
    average = sparse.lil_matrix((n, len(channels) * n_runs))
    for i, (channel, rows, weights, _, _) in enumerate(entries):
        average[i, channel * n_runs + rows] = weights
    settings = run_features(conditions, preload, thresholds["length_scales"])
    features = np.array([settings[rows].mean(axis=0) for _, rows, *_ in entries]).reshape(
        n, settings.shape[1]
    )
    first = [rows[0] for _, rows, *_ in entries]
    shared = shared_edge_sd(conditions, voltage_off_doubt(table))
    unit = [1.0 / channels[e[0]].unit_scale if channels[e[0]].block == TIMED_BLOCK else 0.0 for e in entries]
    fall = FALL_SD * np.array(unit)
    edge = shared[np.array(first, dtype=int)] * np.array(unit)
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
        np.concatenate([np.zeros(n), bench.offset_sd]),
        np.concatenate([edge, np.zeros(len(bench.values))]),
        np.concatenate([fall, np.zeros(len(bench.values))]),
        np.concatenate([conditions.frequency[first], np.zeros(len(bench.values))]),
        join(["run"] * n, bench.block),
        np.concatenate([_widen(features, wide), _widen(bench.features, wide)]),
        average.tocsr(),
        bench,
        preload,
        zero_unknown(table),
        groups,
        groups[np.array(first, dtype=int)],
        tuple(odd),
        run_values,
    )


def _labels(names: Sequence[str]) -> IntArray:
    return np.unique(np.array(names, dtype=object).astype(str), return_inverse=True)[1]


def _widen(features: FloatArray, columns: int) -> FloatArray:
    return np.pad(features, ((0, 0), (0, columns - features.shape[1])))
