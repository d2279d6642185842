"""What was set in each run, as the smooth terms see it, and its preload as far as the run itself tells."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from eaclutch.records import FloatArray, Friction, RunConditions


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


def estimated_preload(table: pd.DataFrame, conditions: RunConditions, friction: Friction) -> FloatArray:
    """Preload [N] (runs,): runs.csv's, or the friction before over the coefficients' sum where it has none."""
    estimate = conditions.friction_before / friction.sliding
    if "preload_n" in table:
        read = pd.to_numeric(table["preload_n"], errors="coerce").to_numpy(dtype=float)
        estimate = np.where(np.isfinite(read), read, estimate)
    return np.nan_to_num(estimate)
