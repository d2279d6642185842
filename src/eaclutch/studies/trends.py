"""The paper's trends from runs.csv and from the calibrated model, each beside the printed number.

Source: Rauf & Follmer (2025), Secs. 3.3, 4 and Supplement S6, doi:10.1016/j.eml.2025.102382.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from eaclutch.records import FloatArray

HALF = 0.5  # -3 dB as 10 log10 of the force, which is what the printed bandwidth comes to
HALF_POWER = 1 / np.sqrt(2)  # -3 dB as 20 log10


def force_exponents(runs: pd.DataFrame, width_mm: float = 2.0, preload_max_n: float = 0.25) -> pd.DataFrame:
    """Exponent n of capacity ~ V^n per drive frequency: least squares on the logs of condition means.

    ``runs``: rows of runs.csv. Returns frequency_hz, exponent, exponent_sd, voltages (levels used); only
    frequencies with three voltages or more.
    """
    chosen = runs[(runs["width_mm"] == width_mm) & (runs["preload_n"] < preload_max_n)]
    chosen = chosen[chosen["shear_capacity_n"] > 0]
    rows = []
    for frequency, group in chosen.groupby("frequency_hz"):
        means = group.groupby("voltage_v")["shear_capacity_n"].mean()
        if len(means) < 3:
            continue
        x = np.log(means.index.to_numpy(dtype=float))
        coefficients, covariance = np.polyfit(x, np.log(means.to_numpy()), 1, cov="unscaled")
        residual = np.log(means.to_numpy()) - np.polyval(coefficients, x)
        scale = residual @ residual / max(1, len(x) - 2)
        rows.append((frequency, coefficients[0], np.sqrt(covariance[0, 0] * scale), len(means)))
    return pd.DataFrame(rows, columns=["frequency_hz", "exponent", "exponent_sd", "voltages"])


def slope(runs: pd.DataFrame, by: str, observable: str, where: pd.Series) -> tuple[float, float]:
    """Least-squares slope of an observable over a column of runs.csv, and its standard error."""
    chosen = runs[where].dropna(subset=[by, observable])
    if chosen[by].nunique() < 2 or len(chosen) < 4:
        return np.nan, np.nan
    coefficients, covariance = np.polyfit(chosen[by], chosen[observable], 1, cov=True)
    return float(coefficients[0]), float(np.sqrt(covariance[0, 0]))


def bandwidth(
    response: Callable[[FloatArray], FloatArray], level: float = HALF, low: float = 10.0, high: float = 1e6
) -> float:
    """Frequency [Hz] at which ``response`` has fallen to ``level`` of its value at ``low``; NaN if it has not."""
    reference = float(response(np.array([low]))[0])

    def excess(log_frequency: float) -> float:
        return float(response(np.array([np.exp(log_frequency)]))[0]) / reference - level

    if excess(np.log(high)) > 0:
        return float("nan")
    return float(np.exp(brentq(excess, np.log(low), np.log(high), xtol=1e-6)))


def release_by_frequency(runs: pd.DataFrame, voltages: tuple[float, ...] | None = None) -> pd.DataFrame:
    """Mean 10 % and 90 % release times per drive frequency (narrow strips, low preload)."""
    chosen = runs[(runs["width_mm"] == 2.0) & (runs["preload_n"] < 0.25)]
    if voltages:
        chosen = chosen[chosen["voltage_v"].isin(voltages)]
    names = ["release_time_10_s", "release_time_90_s"]
    grouped = chosen.groupby("frequency_hz")[names]
    table = grouped.mean().join(grouped.sem().add_suffix("_sem")).join(grouped.count().add_suffix("_runs"))
    return table.reset_index()
