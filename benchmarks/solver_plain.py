"""A plain transcription of the paper's equations: solve_ivp for film and tip, quad inside every evaluation.

What one would write first, at scipy's default tolerances made just tight enough; the yardstick of `fast`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from eaclutch.physics import laws
from eaclutch.records import FloatArray

GRID = np.geomspace(1e-12, 1.0, 400)


def step_response(p: np.void) -> Callable[[float], float]:
    """The step response of one run as the published scripts hold it: tabulated, interpolated."""
    tau, exponent = float(p["relaxation_time"]), float(p["exponent"])
    left = np.array([laws.mittag_leffler(exponent, t / tau) for t in GRID])
    return lambda t: float(np.interp(t, GRID, left))


def release(
    p: np.void, response: Callable[[float], float], preload: float, gap: float, start: float
) -> float:
    """Time [s] from switch-off until the tip has first come back to x = 0, or stops."""
    load = preload + p["film_weight"]
    area_scale = p["contact_scale"] / p["sigma"] ** 1.5

    def rates(t: float, y: FloatArray) -> list[float]:
        h, v, x, u = y
        left = response(t)
        kappa = p["kappa_infinity"] + (p["kappa_driven"] - p["kappa_infinity"]) * left
        volt2 = (p["voltage"] * np.exp(-t / p["fall_time_constant"])) ** 2
        pull = (
            p["force_scale"] * volt2 * laws.roughness_average(h, p["thickness"] / kappa, p["sigma"], p["cut"])
        )
        lift = area_scale * p["sigma"] ** 1.5 * float(laws.greenwood_williamson(h / p["sigma"]))
        net = lift - pull - load - p["damping"] / h**3 * v
        base = p["substrate_weight"] + load + net
        force = p["stiffness"] * x
        if u > -1e-9 and force < p["base_static"] * base + p["film_static"] * lift:
            return [v, net / p["film_mass"], 0.0, -u * 1e6]
        friction = p["base_kinetic"] * base + p["film_kinetic"] * lift
        return [v, net / p["film_mass"], u, (friction - force - p["load_cell_damping"] * u) / p["mass"]]

    def back(t: float, y: FloatArray) -> float:
        return y[2]

    def stopped(t: float, y: FloatArray) -> float:
        return y[3] if t > 2e-4 else -1.0

    back.terminal, back.direction = True, -1  # type: ignore[attr-defined]
    stopped.terminal, stopped.direction = True, 1  # type: ignore[attr-defined]
    x0 = start / p["stiffness"]
    result = solve_ivp(rates, (0.0, 0.02), [gap, 0.0, x0, 0.0], method="LSODA", rtol=1e-6,
                       atol=[1e-13, 1e-8, 1e-10, 1e-7], events=[back, stopped])  # fmt: skip
    return float(result.t[-1])


def engagement(
    p: np.void, response: Callable[[float], float], preload: float, before: float, driven: float
) -> float:
    """Time [s] after voltage on until the gap has gone 0.5 % of its way."""
    load = preload + p["film_weight"]
    target = before - 0.005 * (before - driven)

    def rates(t: float, y: FloatArray) -> list[float]:
        h, v = y
        left = response(t)
        kappa = p["kappa_driven"] - (p["kappa_driven"] - p["kappa_infinity"]) * left
        volt2 = (p["voltage"] * (1 - np.exp(-t / p["rise_time_constant"]))) ** 2
        pull = (
            p["force_scale"] * volt2 * laws.roughness_average(h, p["thickness"] / kappa, p["sigma"], p["cut"])
        )
        lift = p["contact_scale"] * float(laws.greenwood_williamson(h / p["sigma"]))
        return [v, (lift - pull - load - p["damping"] / h**3 * v) / p["film_mass"]]

    def crossed(t: float, y: FloatArray) -> float:
        return y[0] - target

    crossed.terminal, crossed.direction = True, -1  # type: ignore[attr-defined]
    result = solve_ivp(
        rates, (0.0, 1e-3), [before, 0.0], method="LSODA", rtol=1e-6, atol=[1e-13, 1e-8], events=crossed
    )
    return float(result.t[-1])
