"""The mean air gap behind a capacitance reading (physics.md 1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from eaclutch.records import Bench, CapacitanceReadings, FloatArray

VACUUM_PERMITTIVITY = 8.8541878128e-12  # F/m
NOMINAL_KAPPA = 53.2  # PVDF terpolymer at the meter's 1 kHz, as printed in the paper


def gap_from_capacitance(
    capacitance: ArrayLike,
    width: ArrayLike,
    kappa: ArrayLike,
    bench: Bench,
    *,
    film_thickness: float | None = None,
) -> FloatArray:
    """Mean gap [m] from capacitance [F] on the fixture, for substrates of ``width`` [m]; arguments broadcast.

    h = N eps0 A / (4 C) - T_d / kappa with A = L_e w; parallel plates: h = eps0 A / C - T_d / kappa with
    A = overlap x width. The bench's stray capacitance is taken off first. Rauf & Follmer (2025), eq. of the gap.
    """
    pad = bench.pad
    thickness = pad.film_thickness if film_thickness is None else film_thickness
    own = np.asarray(capacitance, dtype=float) - bench.fixture.stray_capacitance
    width = np.asarray(width, dtype=float)
    if pad.type == "interdigitated":
        geometry = pad.electrodes * pad.electrode_length * width / 4.0
    else:
        geometry = bench.fixture.overlap_length * width
    with np.errstate(divide="ignore"):
        return VACUUM_PERMITTIVITY * geometry / own - thickness / np.asarray(kappa, dtype=float)


def gap_table(
    readings: CapacitanceReadings,
    bench: Bench,
    *,
    kappa: float = NOMINAL_KAPPA,
    widths: Sequence[float] = (),
    force_max: float = np.inf,
) -> dict[str, Any]:
    """Columns of gap.csv: source, trial, width_mm, force_n, capacitance_pf, gap_um, used, reason.

    The gaps are for looking at, with one ``kappa`` at the meter's frequency: the contact fit uses the readings and the
    dielectric posterior. ``widths`` [m] (empty: all) and ``force_max`` [N] say which readings the fit uses.
    """
    gap = gap_from_capacitance(readings.capacitance, readings.width, kappa, bench)
    reasons = []
    for width, force in zip(readings.width, readings.force, strict=True):
        if len(widths) and np.min(np.abs(np.asarray(widths) - width)) > 1e-6:
            reasons.append(f"width {width * 1e3:g} mm is not among those chosen for the contact fit")
        else:
            reasons.append("" if force <= force_max else f"force above {force_max:g} N")
    return {
        "source": readings.source,
        "trial": readings.trial,
        "width_mm": readings.width * 1e3,
        "force_n": readings.force,
        "capacitance_pf": readings.capacitance * 1e12,
        "gap_um": gap * 1e6,
        "used": [not reason for reason in reasons],
        "reason": reasons,
    }
