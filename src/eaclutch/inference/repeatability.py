"""How far a run lies from its condition for reasons that no parameter knows: repeats and sessions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eaclutch.inference.cells import Cells
from eaclutch.records import FloatArray

LEAST_FREEDOM = 3  # degrees of freedom below which a spread between sessions is not estimated


@dataclass(frozen=True)
class Scatter:
    """Scatter of an observable around its condition: ``repeat`` within (condition, session), ``session`` between the
    sessions of a condition. ``relative``: in units of the value itself rather than of the observable. dof: degrees
    of freedom of ``repeat``; without any, repeats are taken as no worse than the measurement (0)."""

    repeat: float
    session: float
    relative: bool
    dof: int

    def sd(self, value: FloatArray) -> FloatArray:
        """Standard deviation of a run of its own session around predicted values, same shape."""
        return np.hypot(self.repeat, self.session) * (np.abs(value) if self.relative else np.ones_like(value))


def scatter(values: FloatArray, sds: FloatArray, preload: FloatArray, cells: Cells) -> Scatter:
    """Scatter of one observable beyond its measurement error ``sds``; values (runs,) are NaN where unusable.

    One slope on the preload within cells is taken out first.

    Absolute or relative, whichever the deviations follow better (Gaussian likelihood of equal degrees of freedom).
    """
    use = np.isfinite(values)
    if use.sum() < 4:
        return Scatter(0.0, 0.0, False, 0)
    values, preload, cell = values[use], preload[use], cells.cell[use]
    own = np.nan_to_num(sds[use])
    condition = cells.cell_condition[cell]
    deviation, spread = _centred(values, cell), _centred(np.nan_to_num(preload), cell)
    dof = len(values) - len(np.unique(cell))
    if dof > LEAST_FREEDOM and spread @ spread > 1e-9:
        deviation = deviation - spread * (spread @ deviation) / (spread @ spread)
        dof -= 1
    if dof <= 0:
        return Scatter(0.0, 0.0, False, 0)
    size = np.abs(values - deviation)  # each cell's level
    absolute = float(np.sqrt(deviation @ deviation / dof))
    ratio = deviation / np.maximum(size, 1e-300)
    share = float(np.sqrt(ratio @ ratio / dof))
    fits_absolute = -len(values) * np.log(max(absolute, 1e-300))
    fits_relative = -len(values) * np.log(max(share, 1e-300)) - np.sum(np.log(np.maximum(size, 1e-300)))
    relative = bool(np.all(values > 0) and fits_relative > fits_absolute)
    total = share if relative else absolute
    measured = own / np.maximum(size, 1e-300) if relative else own
    beyond = float(np.sqrt(max(total**2 - float(np.mean(measured**2)), 0.0)))
    logs = np.log(values) if relative else values
    return Scatter(beyond, _between(logs, cell, condition, total), relative, dof)


def _between(values: FloatArray, cell: np.ndarray, condition: np.ndarray, repeat: float) -> float:
    """Sd between the sessions of a condition by the method of moments, over conditions seen in several."""
    excess, freedom = 0.0, 0
    for label in np.unique(condition):
        cells = np.unique(cell[condition == label])
        if len(cells) < 2:
            continue
        means = np.array([values[cell == c].mean() for c in cells])
        counts = np.array([np.sum(cell == c) for c in cells])
        excess += float(np.sum((means - means.mean()) ** 2)) - repeat**2 * (1 - 1 / len(cells)) * np.sum(
            1 / counts
        )
        freedom += len(cells) - 1
    return float(np.sqrt(max(excess, 0.0) / freedom)) if freedom >= LEAST_FREEDOM else 0.0


def _centred(values: FloatArray, group: np.ndarray) -> FloatArray:
    _, index = np.unique(group, return_inverse=True)
    return values - (np.bincount(index, values) / np.bincount(index))[index]
