"""Capacitance, permittivity and load-cell readings of a sealed bench."""

from __future__ import annotations

import numpy as np

from eaclutch.blind.contact import contact_shape
from eaclutch.blind.world import VACUUM_PERMITTIVITY, Constants, real_permittivity
from eaclutch.records import BurstFeatures, CapacitanceReadings, FloatArray, Spectrum

TRIALS = (("2", 2e-3), ("2", 2e-3), ("2.5", 2.5e-3), ("2.5", 2.5e-3), ("3", 3e-3), ("3", 3e-3))


def pressure_of(gap: FloatArray, c: Constants) -> FloatArray:
    """Contact pressure [N/m2] at mean gap [m], same shape."""
    return c.contact_stiffness * c.roughness_sd**1.5 * contact_shape(gap / c.roughness_sd, c.law, c.law_share)


def capacitance_curve(c: Constants, force: FloatArray, width: float) -> FloatArray:
    """Capacitance of the fixture without noise [F] at normal forces [N] (readings,), stray one included."""
    kappa = real_permittivity(
        np.array(c.meter_frequency), c.kappa_static, c.kappa_infinity, c.relaxation_time, c.cole_cole_exponent
    )
    gap = np.linspace(0.3, 4.5, 900) * c.roughness_sd
    here = np.interp(force, (pressure_of(gap, c) * c.fixture_length * width)[::-1], gap[::-1])
    plate = c.electrodes * VACUUM_PERMITTIVITY * kappa * c.electrode_length * width
    return plate / (4 * (c.film_thickness + kappa * here)) + c.stray_capacitance


def draw_capacitance(c: Constants, rng: np.random.Generator) -> CapacitanceReadings:
    """Six trials of forty readings from 0.05 to 6 N; seating and the meter scatter each trial a little."""
    kappa = float(
        real_permittivity(
            np.array(c.meter_frequency),
            c.kappa_static,
            c.kappa_infinity,
            c.relaxation_time,
            c.cole_cole_exponent,
        )
    )
    gap = np.linspace(0.3, 4.5, 900) * c.roughness_sd
    pressure = (
        c.contact_stiffness * c.roughness_sd**1.5 * contact_shape(gap / c.roughness_sd, c.law, c.law_share)
    )
    columns: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    names: list[str] = []
    for number, (label, width) in enumerate(TRIALS, start=1):
        force = np.sort(rng.uniform(0.05, 6.0, 40))
        seat = rng.normal(0, 0.06e-6)
        stiff = np.exp(rng.normal(0, 0.03))
        line = pressure * c.fixture_length * width * stiff
        here = np.interp(force, line[::-1], gap[::-1]) + seat
        area = c.electrode_length * width
        plate = c.electrodes * VACUUM_PERMITTIVITY * kappa * area / (4 * (c.film_thickness + kappa * here))
        reading = plate * (1 + rng.normal(0, 0.003, len(force))) + c.stray_capacitance
        columns.append((np.round(force, 4), np.round(reading * 1e12, 2) * 1e-12, np.full(len(force), width)))
        names += [f"w={label} ({number})"] * len(force)
    loads, values, widths = (np.concatenate(part) for part in zip(*columns, strict=True))
    return CapacitanceReadings(loads, values, widths, tuple(names), ("capacitance.csv",) * len(loads))


def draw_spectra(c: Constants, rng: np.random.Generator) -> tuple[Spectrum, ...]:
    """Two digitised literature spectra, each with a scale of its own, and the vendor's four points."""

    def kappa(frequency: np.ndarray) -> np.ndarray:
        return real_permittivity(
            frequency, c.kappa_static, c.kappa_infinity, c.relaxation_time, c.cole_cole_exponent
        )

    out = []
    for name, low, high, points, scale_sd in (
        ("literature_a", 30, 1e6, 45, 0.02),
        ("literature_b", 2e3, 2e6, 55, 0.03),
    ):
        frequency = np.geomspace(low, high, points) * np.exp(rng.normal(0, 0.01, points))
        scale = np.exp(rng.normal(0, scale_sd))
        out.append(Spectrum(name, frequency, kappa(frequency) * scale * (1 + rng.normal(0, 0.004, points))))
    frequency = np.array([1e3, 1e4, 1e5, 1e6])
    out.append(Spectrum("vendor", frequency, kappa(frequency) * (1 + rng.normal(0, 0.005, 4))))
    return tuple(out)


def draw_bursts(c: Constants, rng: np.random.Generator) -> BurstFeatures:
    """Ten free swings of the bare load cell."""
    natural = np.sqrt(c.stiffness / c.mass) / (2 * np.pi)
    zeta = c.damping / (2 * np.sqrt(c.stiffness * c.mass))
    frequency_sd, zeta_sd = rng.uniform(1.0, 3.0, 10), rng.uniform(0.0015, 0.004, 10)
    return BurstFeatures(
        natural + frequency_sd * rng.standard_normal(10),
        frequency_sd,
        zeta + zeta_sd * rng.standard_normal(10),
        zeta_sd,
    )
