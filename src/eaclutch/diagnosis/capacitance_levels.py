"""Capacitance readings thinned to levels of force: what trials say together, and how far one differs from the next.

A trial seats the film anew, so it is off by much the same at every force, and by a little more at each: the two are
told apart where a width has several trials. Counted as noise of each level alone, an offset would leave the shape of
the curve looser, and its height tighter, than it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial

from eaclutch.records import CapacitanceReadings, FloatArray

FORCE_LEVELS = np.geomspace(0.1, 8.0, 12)  # N
LARGEST_FORCE = 4.0  # N; beyond it the fixture squeezes more than the clutch ever does
NEAR = 0.19  # in log force: half the way to the next level
USUAL_SD = 0.02 * 0.5**0.5  # of log C, of an offset and of a level each, where no width has two trials
METER_SD = 1e-3  # of log C, at least


@dataclass(frozen=True)
class Level:
    """Mean over a width's trials of log C (F) at a force [N], its sd, and the sd of what it shares with the width's
    other levels."""

    width: float
    force: float
    log_capacitance: float
    sd: float
    offset_sd: float


@dataclass(frozen=True)
class _Width:
    """A width's mean curve (levels,), trials at each level (levels,), offsets (trials,), residuals (trials, levels)."""

    mean: FloatArray
    count: FloatArray
    offsets: FloatArray
    residual: FloatArray
    parameters: int

    @classmethod
    def of(cls, curves: FloatArray) -> _Width:
        """Level means and offsets that sum to zero, by least squares over log C (trials, levels), some not a number."""
        trial, level = np.nonzero(np.isfinite(curves))
        trials, size = curves.shape
        design = np.zeros((len(trial), size + trials))
        design[np.arange(len(trial)), level] = 1.0
        design[np.arange(len(trial)), size + trial] = 1.0
        values = curves[trial, level]
        found, _, rank, _ = np.linalg.lstsq(design, values)
        offsets = found[size:] - found[size:].mean()
        residual = np.full(curves.shape, np.nan)
        residual[trial, level] = values - design @ found
        return cls(
            found[:size] + found[size:].mean(), np.isfinite(curves).sum(axis=0), offsets, residual, int(rank)
        )


def levels(readings: CapacitanceReadings) -> list[Level]:
    """One a width and force level that any trial reaches."""
    trials = np.array([f"{s}|{t}" for s, t in zip(readings.source, readings.trial, strict=True)])
    widths: dict[float, _Width] = {}
    for width in np.unique(readings.width):
        here = readings.width == width
        curves = np.array([_curve(readings, here & (trials == trial)) for trial in np.unique(trials[here])])
        curves = curves[np.isfinite(curves).any(axis=1)]
        if len(curves):
            widths[float(width)] = _Width.of(curves)
    offset, own = _scatter(list(widths.values()))
    return [
        Level(
            width,
            float(FORCE_LEVELS[i]),
            float(found.mean[i]),
            float(np.hypot(max(own, METER_SD) / np.sqrt(found.count[i]), METER_SD)),
            offset / float(np.sqrt(len(found.offsets))),
        )
        for width, found in widths.items()
        for i in np.flatnonzero(found.count)
    ]


def _scatter(widths: list[_Width]) -> tuple[float, float]:
    """Sd of one trial's offset, and of one trial at one level apart from it, pooled over widths."""
    several = [w for w in widths if len(w.offsets) > 1]
    dof = sum(int(w.count.sum()) - w.parameters for w in several)
    own = sum(float(np.nansum(w.residual**2)) for w in several) / dof if dof > 0 else USUAL_SD**2
    between = sum(len(w.offsets) - 1 for w in several)
    if not between:
        return USUAL_SD, float(np.sqrt(own))
    # what scatter at the levels makes of the offsets is no offset
    chance = sum(
        (len(w.offsets) - 1) * own / max(1.0, float(w.count.sum()) / len(w.offsets)) for w in several
    )
    offset = max(0.0, sum(float(np.sum(w.offsets**2)) for w in several) - chance) / between
    return float(np.sqrt(offset)), float(np.sqrt(own))


def _curve(readings: CapacitanceReadings, rows: np.ndarray) -> FloatArray:
    """log C of one trial at the force levels it reaches, (levels,), not-a-number elsewhere: the mean of the readings
    near a level, each carried there along the slope of the trial's own curve."""
    force, capacitance = readings.force[rows], readings.capacitance[rows]
    use = np.isfinite(force) & np.isfinite(capacitance) & (capacitance > 0) & (force > 0)
    log_force, log_c = np.log(force[use]), np.log(capacitance[use])
    curve = np.full(len(FORCE_LEVELS), np.nan)
    if not len(log_force):
        return curve
    middle, width = float(log_force.mean()), max(float(np.std(log_force)), 1e-6)
    order = min(2, len(np.unique(log_force)) - 1)
    slope = polynomial.polyder(polynomial.polyfit((log_force - middle) / width, log_c, order))
    for i, level in enumerate(np.log(FORCE_LEVELS)):
        near = np.abs(log_force - level) < NEAR
        if np.exp(level) <= LARGEST_FORCE and near.any():
            half_way = (0.5 * (level + log_force[near]) - middle) / width
            there = log_c[near] + polynomial.polyval(half_way, slope) * (level - log_force[near]) / width
            curve[i] = float(np.mean(there))
    return curve
