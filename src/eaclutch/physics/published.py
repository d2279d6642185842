"""The release model of the paper's published scripts, with its own choices, to explain where its curves differ.

Not the base model: a preset to compare with. What it does otherwise, as the authors' public repository shows
(ahadrauf/fast-electroadhesive-clutches, read for facts, nothing copied):

* the contact acts on the electrodes' area N L_e w, not on the overlap L_s w;
* the tip starts at (1 - ratio) of the way from the static friction without to that with voltage, not at ratio;
* the release ends at the first instant of zero velocity, and friction goes on where the tip has lost contact;
* after switch-off kappa is (kappa_s - kappa_inf) E(t): it jumps from kappa(f), and ends at 0 instead of kappa_inf;
* the squeeze film has a finite-width factor 1 - 0.58 w / L and 1.82e-5 Pa s; the strip counts with 95 mm;
* the force multiplier is 1.70824e-5 V^2 - 0.01352372 V + 3.208127 (the printed one is 2.40 - 0.0058 V).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from eaclutch.physics import laws
from eaclutch.physics.kernels.lookup import log_contact, relaxation, rough_row, rough_value
from eaclutch.physics.tables import tables
from eaclutch.records import FloatArray, Pad

STIFFNESS, MASS, DAMPING = 18017.8068, 0.001100401, 0.427433527  # load cell, N/m, kg, kg/s
CONTACT_STIFFNESS, ROUGHNESS, CUT = 5.39050698e14, 2.80263157e-6, 0.83
STATIC, KINETIC = (0.281, 0.188), (0.173, 0.154)  # base, film
KAPPA_STATIC, KAPPA_INFINITY, RELAXATION_TIME, EXPONENT = 54.2, 4.0, 2.82e-6, 0.562
FALL_TIME_CONSTANT = 5.2e-6 / np.log(9.0)


@dataclass(frozen=True)
class PublishedRelease:
    """release_time [s] until the first zero of the velocity, release_time_10 [s], start and end force [N]."""

    release_time: float
    release_time_10: float
    start_force: float
    end_force: float


def multiplier(voltage: float) -> float:
    """Force multiplier of the published scripts."""
    return 1.70824e-5 * voltage**2 - 0.01352372 * voltage + 3.208127237


def published_release(
    voltage: float, width: float, thickness: float, preload: float, start_ratio: float, frequency: float = 1000.0,
    *, start_at_ratio: bool = False, contact_on_overlap: bool = False,
) -> PublishedRelease:  # fmt: skip
    """One release on the paper's pad; SI units. Raises RuntimeError where the tip never moves.

    ``start_at_ratio``, ``contact_on_overlap``: the paper's words instead of the scripts' choice, one at a time.
    """
    pad, table = Pad(), tables()
    area = (pad.overlap_length if contact_on_overlap else pad.electrodes * pad.electrode_length) * width
    film_mass = 1780.0 * pad.film_thickness * pad.overlap_length * width
    strip_mass = 8049.0 * 0.095 * width * thickness
    load = preload + laws.GRAVITY * film_mass
    base = load + laws.GRAVITY * strip_mass
    finite = (1.82e-5 / laws.AIR_VISCOSITY) * (1.0 - 0.58 * width / pad.overlap_length)
    squeeze = float(laws.squeeze_film_coefficient(pad.overlap_length, width)) * finite
    scale = float(laws.force_scale(pad, width)) * multiplier(voltage) * voltage**2

    def lift(h: float) -> float:
        log_g, _ = log_contact(h / ROUGHNESS, table.contact)
        return CONTACT_STIFFNESS * area * ROUGHNESS**1.5 * float(np.exp(log_g))

    def pull(h: float, kappa: float) -> float:
        film = pad.film_thickness / max(kappa, 1e-3)
        a, u = (1.0 - CUT) * film / ROUGHNESS, (h + CUT * film) / ROUGHNESS
        row, coordinate = rough_row(a)
        return scale * float(rough_value(a, row, coordinate, u, table.roughness)) / ROUGHNESS**2

    driven_kappa = float(
        laws.permittivity(frequency, KAPPA_STATIC, KAPPA_INFINITY, RELAXATION_TIME, EXPONENT)
    )
    before = brentq(lambda h: np.log(lift(h) / load), 0.1 * ROUGHNESS, 5 * ROUGHNESS, xtol=1e-15)
    driven = brentq(
        lambda h: np.log(lift(h) / (load + pull(h, driven_kappa))), 0.1 * ROUGHNESS, before, xtol=1e-15
    )
    rest, held = (STATIC[0] * base + STATIC[1] * lift(h) for h in (before, driven))
    start = rest + (held - rest) * (start_ratio if start_at_ratio else 1.0 - start_ratio)

    def net(t: float, h: float, v: float) -> float:
        left, _ = relaxation(EXPONENT, t / RELAXATION_TIME, table.relaxation)
        now = np.exp(-2.0 * t / FALL_TIME_CONSTANT) * pull(h, (KAPPA_STATIC - KAPPA_INFINITY) * left)
        return lift(h) - now - load - squeeze / h**3 * v

    def friction(t: float, h: float, v: float, coefficients: tuple[float, float]) -> float:
        return coefficients[0] * (base + net(t, h, v)) + coefficients[1] * lift(h)

    def stuck(t: float, y: FloatArray) -> list[float]:
        return [y[1], net(t, y[0], y[1]) / film_mass]

    def slides(t: float, y: FloatArray) -> float:
        return friction(t, y[0], y[1], STATIC) - start

    def sliding(t: float, y: FloatArray) -> list[float]:
        push = friction(t, y[0], y[1], KINETIC) - STIFFNESS * y[2] - DAMPING * y[3]
        return [y[1], net(t, y[0], y[1]) / film_mass, y[3], push / MASS]

    def stops(_: float, y: FloatArray) -> float:
        return y[3]

    slides.terminal = stops.terminal = True  # type: ignore[attr-defined]
    slides.direction, stops.direction = -1, 1  # type: ignore[attr-defined]
    way, x0 = before - driven, start / STIFFNESS
    scales = np.array([way, way / 1e-5, x0, 4000.0 * x0])
    first = solve_ivp(
        stuck, (0.0, 0.05), [driven, 0.0], "Radau", rtol=1e-7, atol=1e-7 * scales[:2], events=slides
    )
    if first.status != 1:
        raise RuntimeError("the tip never moves")
    state = [*first.y[:, -1], x0, 0.0]
    second = solve_ivp(
        sliding, (first.t[-1], 0.1), state, "Radau", rtol=1e-7, atol=1e-7 * scales, events=stops
    )
    x = second.y[2]
    tenth = np.interp(-0.9 * x0 - 0.1 * x[-1], -x, second.t)
    return PublishedRelease(float(second.t[-1]), float(tenth), start, float(STIFFNESS * x[-1]))
