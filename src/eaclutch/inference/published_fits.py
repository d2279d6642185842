"""The paper's point fits by its own choices, and how far each choice moves them (Rauf & Follmer 2025).

The fits are least squares without a likelihood. Applied to data replicated from our posterior they say where such a
fit must lie if the posterior is right; the authors' values are compared with that spread.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import least_squares

from eaclutch.physics.laws import capacitance_scale, contact_force, permittivity
from eaclutch.records import Bench, CapacitanceReadings, FloatArray, Spectrum

FORCE_STEPS = 400
KAPPA_INFINITY = 4.0  # held by the authors
STARTS = ((5e14, 2.8e-6), (1e14, 3.4e-6), (2e15, 2.3e-6))
FITS_OF_VOLTAGE = 100.0  # V; below it the paper has no multiplier


def contact_fit(
    readings: CapacitanceReadings, bench: Bench, *, film: float, kappa: float, force_max: float
) -> tuple[float, float]:
    """Contact stiffness [N m^-3.5] and roughness [m], each the mean over widths.

    Per width: the trials' gaps (with a film of ``film`` [m] and ``kappa``) interpolated at 400 equal force steps up
    to ``force_max`` [N], averaged, and fitted by least squares on the force.
    """
    found = []
    for width in np.unique(readings.width):
        curves = _gap_curves(readings, bench, width, film / kappa)
        last = min(force_max, *(force[-1] for force, _ in curves))
        grid = np.linspace(0.0, last, FORCE_STEPS)
        gap = np.mean([np.interp(grid, force, gaps) for force, gaps in curves], axis=0)
        args = (gap, grid, bench.fixture.overlap_length, width)
        fits = [
            least_squares(_contact_miss, np.log(start), x_scale=(1.0, 0.1), args=args) for start in STARTS
        ]
        found.append(np.exp(min(fits, key=lambda fit: fit.cost).x))
    mean = np.mean(found, axis=0)
    return float(mean[0]), float(mean[1])


def _contact_miss(
    p: FloatArray, gap: FloatArray, force: FloatArray, length: float, width: float
) -> FloatArray:
    """Force missed by ln k, ln sigma = p."""
    return contact_force(gap, np.exp(p[0]), np.exp(p[1]), length, width) - force


def _gap_curves(
    readings: CapacitanceReadings, bench: Bench, width: float, offset: float
) -> list[tuple[FloatArray, FloatArray]]:
    """Force and gap of each trial of a width, by increasing force."""
    labels = np.array([f"{s}\0{t}" for s, t in zip(readings.source, readings.trial, strict=True)])
    scale = capacitance_scale(bench.pad, width, bench.fixture.overlap_length)
    curves = []
    for label in np.unique(labels[readings.width == width]):
        rows = np.flatnonzero((labels == label) & (readings.width == width))
        rows = rows[np.argsort(readings.force[rows], kind="stable")]
        stray = bench.fixture.stray_capacitance
        curves.append((readings.force[rows], scale / (readings.capacitance[rows] - stray) - offset))
    return curves


def dielectric_fit(spectra: Sequence[Spectrum], weights: Mapping[str, float]) -> tuple[float, float, float]:
    """kappa_s, tau [s] and alpha by least squares with kappa_inf = 4; a source's squares count ``weights`` times."""
    roots = [np.sqrt(weights.get(s.source, 1.0)) for s in spectra]

    def miss(p: FloatArray) -> FloatArray:
        return np.concatenate(
            [
                root * (permittivity(s.frequency, p[0], KAPPA_INFINITY, np.exp(p[1]), p[2]) - s.permittivity)
                for root, s in zip(roots, spectra, strict=True)
            ]
        )

    fit = least_squares(miss, (52.0, np.log(2.5e-6), 0.58), x_scale=(1.0, 0.1, 0.1))
    return float(fit.x[0]), float(np.exp(fit.x[1])), float(fit.x[2])


def multiplier_fit(
    log_capacity: FloatArray, measured: FloatArray, voltage: FloatArray, multipliers: FloatArray
) -> tuple[float, float, float]:
    """Slope [1/V] and intercept of a line through the multipliers that match each voltage's mean log capacity, and
    their mean over runs.

    log_capacity (grid, runs): the model's at ``multipliers`` (grid,), NaN where it pulls in; measured (runs,) [N].
    """
    levels = np.unique(voltage[voltage >= FITS_OF_VOLTAGE])
    found = np.full(len(levels), np.nan)
    for i, level in enumerate(levels):
        rows = voltage == level
        miss = np.mean(log_capacity[:, rows], axis=1) - np.mean(np.log(measured[rows]))
        known = np.isfinite(miss)
        if known.sum() > 2 and miss[known].min() < 0 < miss[known].max():
            found[i] = np.exp(np.interp(0.0, miss[known], np.log(multipliers[known])))
    known = np.isfinite(found)
    if known.sum() < 2:
        return np.nan, np.nan, float(np.nanmean(found)) if known.any() else np.nan
    slope, intercept = np.polyfit(levels[known], found[known], 1)
    per_run = np.interp(voltage[np.isin(voltage, levels[known])], levels[known], found[known])
    return float(slope), float(intercept), float(per_run.mean())
