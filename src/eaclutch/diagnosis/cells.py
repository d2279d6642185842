"""The gap as the contract counts it: (observable, condition) cells in the observable's own unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from scipy import sparse

from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.repeatability import (
    FEW,
    instead,
    pooled_variance,
    preload_bins,
    shrunk_variance,
)
from eaclutch.records import FloatArray


@dataclass(frozen=True)
class Cells:
    """Cells of a campaign, each array (cells,) unless stated.

    observable, condition: names. variance: of the cell's mean by the pooled repeat variance, in the unit
    squared. gather: sparse (cells, entries): entry errors to cell errors.
    """

    observable: np.ndarray
    condition: np.ndarray
    variance: FloatArray
    gather: sparse.csr_matrix
    level: FloatArray  # (entries,) measured value in the observable's own unit
    log: np.ndarray  # (entries,) whether the entry is compared by its logarithm
    unit_scale: FloatArray  # (entries,)

    def errors(self, scaled: FloatArray) -> FloatArray:
        """Measured less predicted in the observable's unit, (..., cells), from entry errors (..., entries)."""
        return self.native(scaled) @ self.gather.T

    def native(self, scaled: FloatArray) -> FloatArray:
        """Entry errors (..., entries) from the comparison scale to the observable's unit."""
        clipped = np.clip(scaled, -6.0, 6.0)
        found: FloatArray = np.where(self.log, self.level * -np.expm1(-clipped), scaled * self.unit_scale)
        return found

    def mean_square(self, scaled: FloatArray) -> FloatArray:
        """The contract's statistic over all cells, (...,)."""
        return np.mean(self.errors(scaled) ** 2 / self.variance, axis=-1)


def cells_of(data: DataVector, native_variance: dict[str, float]) -> Cells:
    """Cells of the run entries.

    native_variance: variance of a single run of each observable, in its unit squared.
    """
    n = data.run_entries
    keys = [(data.channel[i], data.condition[i]) for i in range(n)]
    names = list(dict.fromkeys(keys))
    index = {key: i for i, key in enumerate(names)}
    count = np.zeros(len(names))
    for i, key in enumerate(keys):
        count[index[key]] += data.count[i]
    gather = sparse.lil_matrix((len(names), n))
    for i, key in enumerate(keys):
        gather[index[key], i] = data.count[i] / count[index[key]]
    by_name = {channel.name: channel for channel in data.channels}
    channels = [by_name[data.channel[i]] for i in range(n)]
    level = np.array([float(c.backward(v)) for c, v in zip(channels, data.values[:n], strict=True)])
    variance = np.array([native_variance[key[0]] for key in names]) / count
    return Cells(
        np.array([key[0] for key in names], dtype=object),
        np.array([key[1] for key in names], dtype=object),
        variance,
        gather.tocsr(),
        level,
        np.array([c.scale == "log" for c in channels], dtype=bool),
        np.array([c.unit_scale for c in channels]),
    )


def repeat_variance(data: DataVector, native_variance: dict[str, float]) -> FloatArray:
    """Variance (entries,) of each entry on the comparison scale that the repeats alone imply.

    The floor's own noise: what the statistic divides by. Bench entries keep the noise they were given.
    """
    variance = data.noise_sd**2
    by_name = {channel.name: channel for channel in data.channels}
    for i in range(data.run_entries):
        channel = by_name[data.channel[i]]
        scale = float(channel.backward(data.values[i])) if channel.scale == "log" else channel.unit_scale
        variance[i] = native_variance[channel.name] / data.count[i] / scale**2
    return variance


def native_variances(
    table: pd.DataFrame, data: DataVector, thresholds: Mapping[str, Any]
) -> tuple[dict[str, float], dict[str, int]]:
    """Repeat variance of a single run of each observable in its unit squared, and its degrees of freedom.

    Where repeats are few (degrees of freedom say so) it is drawn to what runs scatter by across sessions, and that to
    the extractor's own variance and what runs usually scatter by (``unrepeated_sd``): two runs that happen to agree, or
    a place of rest that is read to a permille and reached by chance, would make any gap a huge one, and that observable
    all of it.
    """
    conditions = data.conditions
    keys = [f"{c}|{s}" for c, s in zip(conditions.condition, conditions.session, strict=True)]
    groups = np.unique(keys, return_inverse=True)[1]
    bins = preload_bins(conditions.condition, data.preload)
    variances, dofs = {}, {}
    for channel, scaled in zip(data.channels, data.run_values, strict=True):
        values = pd.to_numeric(table[channel.name], errors="coerce").to_numpy(dtype=float)
        values = np.where(np.isfinite(scaled), values, np.nan)
        repeat = pooled_variance(values, conditions.friction_before, groups, bins)
        own = np.full(len(values), np.nan)
        if f"{channel.name}_sd" in table:
            own = pd.to_numeric(table[f"{channel.name}_sd"], errors="coerce").to_numpy(dtype=float) ** 2
        variance = repeat.variance
        if repeat.dof < FEW or not variance > 0:
            unit = np.nanmean(values**2) if channel.scale == "log" else channel.unit_scale**2
            typical = float(np.nanmedian(own)) if np.isfinite(own).any() else 0.0
            usual = typical + float(thresholds["unrepeated_sd"][channel.block]) ** 2 * float(unit)
            across = instead(repeat, [scaled], conditions)
            across = replace(across, variance=across.variance * float(unit))
            variance = shrunk_variance(repeat, usual, thresholds["repeat_prior_dof"], across)
        variances[channel.name], dofs[channel.name] = variance, repeat.dof
    return variances, dofs
