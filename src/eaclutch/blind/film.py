"""Motion of the film after the voltage falls (and after it rises), on a grid that grows with time."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from eaclutch.blind.contact import electric_force, held_apart
from eaclutch.blind.world import AIR_VISCOSITY, VACUUM_PERMITTIVITY, Constants, Runs
from eaclutch.records import FloatArray

RELEASE_TIMES = np.concatenate([[0.0], np.linspace(0.5e-6, 12e-6, 24), np.geomspace(13e-6, 20e-3, 150)])
ENGAGE_TIMES = np.concatenate([[0.0], np.linspace(0.5e-6, 15e-6, 30), np.geomspace(16e-6, 4e-3, 90)])


def relaxation(time_ratio: FloatArray, exponent: float) -> FloatArray:
    """E_alpha(-x^alpha), the Cole-Cole relaxation at x = t / tau >= 0, by its spectrum of exponentials.

    Gorenflo & Mainardi, DOI 10.1007/978-3-7091-2664-6_5, eq. 3.24; the substitution r = exp(y) makes the
    trapezium rule converge geometrically.
    """
    y = np.linspace(-60, 60, 1201)
    r_alpha = np.exp(exponent * y)
    spectrum = np.sin(np.pi * exponent) / (np.pi * (r_alpha + 2 * np.cos(np.pi * exponent) + 1 / r_alpha))
    x = np.asarray(time_ratio, float)[..., None]
    return np.sum(spectrum * np.exp(-x * np.exp(np.minimum(y, 300))), axis=-1) * (y[1] - y[0])


def squeeze_coefficient(gap: FloatArray, runs: Runs, c: Constants) -> FloatArray:
    """Damping [kg/s] of the air film of a long strip at mean gap (runs,); rarefied by Veijola's fit.

    mu / (1 + 9.638 Kn^1.159), DOI 10.1016/0924-4247(95)00995-7, where the knob ``mean_free_path`` is set.
    """
    short, long = np.minimum(runs.width, c.overlap_length), np.maximum(runs.width, c.overlap_length)
    knudsen = runs.knob("mean_free_path") / gap
    viscosity = AIR_VISCOSITY * runs.knob("squeeze_factor", 1.0) / (1 + 9.638 * knudsen**1.159)
    return 96 * viscosity * short**3 * long / np.pi**4 / gap**3


def pad_capacitance(gap: FloatArray, runs: Runs, c: Constants) -> FloatArray:
    """Capacitance of the comb [F] (runs,) at mean gap."""
    return (
        VACUUM_PERMITTIVITY
        * c.electrodes
        * runs.area(c)
        * runs.kappa
        / (4 * (runs.film_thickness + runs.kappa * gap))
    )


def falling_edge(time: float, gap_on: FloatArray, runs: Runs, c: Constants) -> tuple[FloatArray, FloatArray]:
    """Drive voltage over its amplitude (runs,) ``time`` seconds after the logged fall, and where it is fed.

    A weak supply (knob ``slew_current``, A) empties the pad at constant current: slow against the dipoles,
    which follow the field there (second array true) instead of relaxing since the edge.
    """
    late = time - runs.knob("delay_off")
    edge = np.exp(-np.maximum(late, 0) / (c.fall_90_10 / np.log(9)))
    current = runs.knob("slew_current")
    ramp = np.zeros_like(edge)
    if np.any(current > 0):
        slew = np.where(current > 0, pad_capacitance(gap_on, runs, c) / np.maximum(current, 1e-12), 0)
        ramp = np.maximum(1 - np.maximum(late, 0) / np.maximum(slew * runs.voltage, 1e-12), 0)
    return np.where(late < 0, 1.0, np.maximum(edge, ramp)), ramp > edge


def charge_left(time: float, runs: Runs) -> FloatArray:
    """Field of the charge left in the film over the driven one (runs,): a power of time."""
    late = np.maximum(time - runs.knob("delay_off"), 0)
    fade = (1 + late / runs.knob("residual_time", 1e-3)) ** -runs.knob("residual_power", 1.0)
    return runs.knob("residual") * fade


def _march(
    gap: FloatArray,
    times: FloatArray,
    force: Callable[[FloatArray, float], FloatArray],
    runs: Runs,
    c: Constants,
) -> FloatArray:
    """Overdamped film: dh/dt = force / damping, exponential midpoint rule; gaps (times, runs)."""
    out = np.empty((len(times), len(gap)))
    out[0] = gap
    floor, ceiling = 0.1 * c.roughness_sd, 12 * c.roughness_sd
    for i, (start, stop) in enumerate(itertools.pairwise(times)):
        middle, step = (start + stop) / 2, stop - start
        nudge = 1e-4 * gap
        speed = force(gap, middle) / squeeze_coefficient(gap, runs, c)
        pushed = force(gap + nudge, middle) / squeeze_coefficient(gap + nudge, runs, c)
        decay = np.clip((pushed - speed) / nudge * step, -600, 8)
        growth = np.where(np.abs(decay) < 1e-8, 1.0, np.expm1(decay) / np.where(decay == 0, 1, decay))
        gap = np.clip(gap + step * growth * speed, floor, ceiling)
        out[i + 1] = gap
    return out


def release_motion(gap_on: FloatArray, runs: Runs, c: Constants) -> FloatArray:
    """Gap [m] (times, runs) at RELEASE_TIMES after the fall; kappa relaxes from its driven value.

    Charge left in the film is a steady field, so its dipoles stay: its pull has the driven permittivity.
    """
    ratio = relaxation(RELEASE_TIMES / c.relaxation_time, c.cole_cole_exponent)
    kept = runs.knob("residual")
    held = bool(np.any(kept > 0))

    def force(gap: FloatArray, time: float) -> FloatArray:
        net = held_apart(gap, runs, c)
        edge, fed = falling_edge(time, gap_on, runs, c)
        if np.any(edge > 1e-3):
            late = np.maximum(time - runs.knob("delay_off"), 0)
            left = np.where(fed, 1.0, np.interp(late, RELEASE_TIMES, ratio))
            kappa = c.kappa_infinity + (runs.kappa - c.kappa_infinity) * left
            net = net - electric_force(gap, runs.voltage * edge * np.sqrt(1 - kept**2), kappa, runs, c)
        if held:
            net = net - electric_force(gap, runs.voltage * charge_left(time, runs), runs.kappa, runs, c)
        return net

    return _march(gap_on, RELEASE_TIMES, force, runs, c)


def engagement_delay(gap_off: FloatArray, gap_on: FloatArray, runs: Runs, c: Constants) -> FloatArray:
    """Time [s] (runs,) from the logged rise until the film has closed half of its way."""

    def force(gap: FloatArray, time: float) -> FloatArray:
        late = np.maximum(time - runs.knob("delay_on"), 0)
        voltage = runs.voltage * -np.expm1(-late / (c.rise_10_90 / np.log(9)))
        return held_apart(gap, runs, c) - electric_force(gap, voltage, runs.kappa, runs, c)

    gaps = _march(gap_off, ENGAGE_TIMES, force, runs, c)
    half = (gap_off + gap_on) / 2
    crossed = gaps <= half
    first = np.where(crossed.any(axis=0), np.argmax(crossed, axis=0), len(ENGAGE_TIMES) - 1)
    return ENGAGE_TIMES[first] + runs.knob("backlash") / c.stage_speed
