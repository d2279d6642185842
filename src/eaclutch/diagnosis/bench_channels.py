"""The calibration bench as entries of the same comparison: capacitance, permittivity, load-cell bursts.

They stand inside the joint fit because some effects act there: stray capacitance biases the gap, and with it
the contact parameters, however well the runs themselves are measured.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.diagnosis.capacitance_levels import levels
from eaclutch.records import BurstFeatures, CapacitanceReadings, FloatArray, Spectrum

SPECTRUM_POINTS = 10  # per source


@dataclass(frozen=True)
class BenchEntries:
    """Bench entries, (entries,) each: logarithms of capacitance, permittivity, burst frequency and damping.

    setting: force [N], frequency [Hz], or 0/1 for burst frequency/damping; width [m] (capacitance only).
    offset: label of what the entry shares a random offset with; offset_sd: of what all trials of a width have in common
    with themselves, beyond the spread between sessions (capacitance only). features (entries, 2).
    """

    values: FloatArray
    noise_sd: FloatArray
    block: np.ndarray
    offset: np.ndarray
    setting: FloatArray
    width: FloatArray
    offset_sd: FloatArray
    features: FloatArray
    notes: tuple[str, ...] = ()


def summarise(
    readings: CapacitanceReadings | None,
    spectra: Sequence[Spectrum],
    bursts: BurstFeatures | None,
    thresholds: Mapping[str, Any],
    widths: Sequence[float] = (),
) -> BenchEntries:
    """Thin the bench's data to entries; what is missing is said in ``notes``.

    widths [m]: of the bench's substrates; readings on strips of another width come from another substrate with
    another surface, and are left out (empty: all are used).
    """
    scale = thresholds["length_scales"]
    rows: list[tuple] = []
    notes = []
    if readings is not None and len(readings.force):
        readings, strange = _known_widths(readings, widths)
        if strange:
            notes.append(f"capacitance at {strange} mm left out: no substrate of this bench is that wide")
        rows += _capacitance(readings, scale)
    if not any(row[2] == "capacitance" for row in rows):
        notes.append("no capacitance readings: gap, contact stiffness and roughness rest on their priors")
    scatter = _shape_scatter(spectra)
    for spectrum in spectra:
        rows += _spectrum(spectrum, scale, scatter)
    if not spectra:
        notes.append("no permittivity spectra: the dielectric rests on its priors")
    if bursts is not None and len(bursts.frequency):
        rows += _bursts(bursts)
    else:
        notes.append("no load-cell step responses: the load cell rests on its priors")
    return BenchEntries(
        np.array([r[0] for r in rows], dtype=float),
        np.array([r[1] for r in rows], dtype=float),
        np.array([r[2] for r in rows], dtype=object),
        np.array([r[3] for r in rows], dtype=object),
        np.array([r[4] for r in rows], dtype=float),
        np.array([r[5] for r in rows], dtype=float),
        np.array([r[8] for r in rows], dtype=float),
        np.array([r[6:8] for r in rows], dtype=float).reshape(len(rows), 2),
        tuple(notes),
    )


def _capacitance(readings: CapacitanceReadings, scale: Mapping[str, float]) -> list[tuple]:
    """One entry a width and force level: the mean over trials of log C."""
    return [
        (level.log_capacitance, level.sd, "capacitance", f"w{level.width:.6g}", level.force, level.width,
         np.log(level.force) / scale["log_force"], np.log(level.width) / scale["log_width"], level.offset_sd)
        for level in levels(readings)
    ]  # fmt: skip


def _known_widths(readings: CapacitanceReadings, widths: Sequence[float]) -> tuple[CapacitanceReadings, str]:
    """The readings at one of ``widths``, and the other widths [mm] as text."""
    if not len(widths):
        return readings, ""
    known = np.min(np.abs(readings.width[:, None] - np.asarray(widths)), axis=1) < 1e-5
    strange = ", ".join(f"{w * 1e3:g}" for w in np.unique(readings.width[~known]))
    rows = np.flatnonzero(known)
    kept = CapacitanceReadings(
        readings.force[rows], readings.capacitance[rows], readings.width[rows],
        tuple(readings.trial[i] for i in rows), tuple(readings.source[i] for i in rows),
    )  # fmt: skip
    return kept, strange


def _shape_scatter(spectra: Sequence[Spectrum]) -> float:
    """How far two sources differ in the shape of log permittivity, beyond a common factor: sd of one source.

    Literature spectra of nominally one polymer disagree far beyond the precision they quote.
    """
    squares, count = 0.0, 0
    for i, one in enumerate(spectra):
        for other in spectra[i + 1 :]:
            low = max(one.frequency.min(), other.frequency.min())
            high = min(one.frequency.max(), other.frequency.max())
            if high <= low:
                continue
            grid = np.linspace(np.log(low), np.log(high), 12)
            difference = _log_at(one, grid) - _log_at(other, grid)
            squares += float(np.sum((difference - difference.mean()) ** 2))
            count += len(grid) - 1
    return float(np.sqrt(0.5 * squares / count)) if count else 0.05


def _log_at(spectrum: Spectrum, log_frequency: FloatArray) -> FloatArray:
    """log permittivity at log frequencies, interpolated."""
    order = np.argsort(spectrum.frequency)
    return np.interp(log_frequency, np.log(spectrum.frequency[order]), np.log(spectrum.permittivity[order]))


def _spectrum(spectrum: Spectrum, scale: Mapping[str, float], scatter: float) -> list[tuple]:
    use = (spectrum.frequency > 0) & (spectrum.permittivity > 0)
    frequency, log_kappa = np.log10(spectrum.frequency[use]), np.log(spectrum.permittivity[use])
    order = np.argsort(frequency)
    rows = []
    for part in np.array_split(order, min(SPECTRUM_POINTS, len(order))) if len(order) else []:
        at = float(np.mean(frequency[part]))
        mean, sd = float(np.mean(log_kappa[part])), max(scatter, 0.01)
        rows.append((mean, sd, "permittivity", spectrum.source, 10.0**at, 0.0,
                     at / scale["log10_frequency"], 0.0, 0.0))  # fmt: skip
    return rows


def _bursts(bursts: BurstFeatures) -> list[tuple]:
    n = len(bursts.frequency)
    frequency, damping = np.log(bursts.frequency), np.log(np.maximum(bursts.damping_ratio, 1e-6))
    scatter_f = float(np.std(frequency, ddof=1)) if n > 1 else 0.01
    scatter_d = float(np.std(damping, ddof=1)) if n > 1 else 0.1
    sd_f = np.hypot(scatter_f / np.sqrt(n), 1e-3)
    sd_d = np.hypot(scatter_d / np.sqrt(n), 1e-2)
    return [
        (float(np.mean(frequency)), sd_f, "bursts", "frequency", 0.0, 0.0, 0.0, 0.0, 0.0),
        (float(np.mean(damping)), sd_d, "bursts", "damping", 1.0, 0.0, 9.0, 0.0, 0.0),
    ]
