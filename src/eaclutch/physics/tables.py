"""Tables of the three expensive functions, built once a process in a few tenths of a second.

* contact: log G(x) of the Greenwood-Williamson integral on a uniform grid of x = h / sigma.
* roughness: log J(a, u), J = integral over t > 0 of (a + t)^-2 phi(t - u) dt, on a grid of (log a, u). Every
  averaged force is sigma^-2 J: a = (1 - c) d / sigma, u = (h + c d) / sigma with d = T_d / kappa (published rule),
  or a = d / sigma, u = h / sigma (clamped rule), so one table serves all parameters.
* relaxation: E_alpha(-y^alpha) on a grid of (alpha, log y).

Each cell holds its polynomial (cubic; bicubic 4 x 4) in the cell's own coordinates, 0 .. 1.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import gammaln, pbdv

from eaclutch.records import FloatArray


class Tables(NamedTuple):
    """Flat: contact (cells, 4); roughness, relaxation (row cells, column cells, 4, 4), row power first."""

    contact: FloatArray
    roughness: FloatArray
    relaxation: FloatArray


# Grids: first node, step, number of nodes. The kernels read these as compile-time constants.
CONTACT_X0, CONTACT_STEP, CONTACT_N = -12.0, 1 / 32, 961  # x in [-12, 18]
ROUGH_A0, ROUGH_A_STEP, ROUGH_A_N = np.log(1e-4), 0.08, 188  # a in [1e-4, 314]
ROUGH_U0, ROUGH_U_STEP, ROUGH_U_N = -8.0, 0.08, 301  # u in [-8, 16]
RELAX_ALPHA0, RELAX_ALPHA_STEP, RELAX_ALPHA_N = 0.04, 0.01, 97  # alpha in [0.04, 1]
RELAX_Y0, RELAX_Y_STEP, RELAX_Y_N = -30.0, 0.1, 521  # log y in [-30, 22]


def contact_table() -> FloatArray:
    """(cells, 4): log G, value and slope at the nodes by the parabolic cylinder functions D_{-5/2}, D_{-3/2}."""
    x = CONTACT_X0 + CONTACT_STEP * np.arange(CONTACT_N)
    constant = gammaln(2.5) - 0.5 * np.log(2 * np.pi)
    upper, lower = pbdv(-2.5, x)[0], pbdv(-1.5, x)[0]
    # G' = -1.5 G_0.5, and G_0.5 = Gamma(1.5) / sqrt(2 pi) exp(-x^2/4) D_{-3/2}: the ratio needs no exponential
    value, slope = constant - x * x / 4 + np.log(upper), -lower / upper * CONTACT_STEP
    ends = np.stack([value[:-1], slope[:-1], value[1:], slope[1:]], axis=-1)
    return np.ascontiguousarray(ends @ _HERMITE.T)


def roughness_table() -> FloatArray:
    """Cells (log a, u) of log J; quadrature by the trapezium rule in log(a + t) with its endpoint
    terms removed by a double-exponential map at the cut."""
    log_a = ROUGH_A0 + ROUGH_A_STEP * np.arange(ROUGH_A_N)
    u = ROUGH_U0 + ROUGH_U_STEP * np.arange(ROUGH_U_N)
    # t = exp(p - exp(-p)) maps the line to t > 0; the trapezium rule converges exponentially there.
    p = np.linspace(-4.2, 3.6, 520)
    t = np.exp(p - np.exp(-p))
    log_jacobian = np.log(t) + np.log1p(np.exp(-p))
    log_gauss = -0.5 * (t[None, :] - u[:, None]) ** 2 - 0.5 * np.log(2 * np.pi)
    kernel = -2 * np.log(np.exp(log_a)[:, None] + t[None, :]) + log_jacobian[None, :] + np.log(p[1] - p[0])
    top = log_gauss.max(axis=1, keepdims=True)
    values = np.exp(kernel - kernel.max()) @ np.exp(log_gauss - top).T
    values = np.log(values) + kernel.max() + top.T
    return _cells(values)


def relaxation_table() -> FloatArray:
    """Cells (alpha, log y) of E_alpha(-y^alpha), by its spectral integral in s = log r."""
    alpha = RELAX_ALPHA0 + RELAX_ALPHA_STEP * np.arange(RELAX_ALPHA_N)
    y = np.exp(RELAX_Y0 + RELAX_Y_STEP * np.arange(RELAX_Y_N))
    values = np.empty((RELAX_ALPHA_N, RELAX_Y_N))
    for row, a in enumerate(alpha):
        if a > 1 - 1e-9:
            values[row] = np.exp(-y)
            continue
        # q = log r^alpha; the poles at q = +-i pi (1 - alpha) set the trapezium step, or a sinh map near alpha = 1
        pole = np.pi * (1 - a)
        if pole > 0.6:
            step = min(0.4 * a, 2 * np.pi * pole / 36)  # the cut-off in q is as sharp as alpha
            q = np.arange(-40.0, 40.0, step)
            jacobian = np.full(q.shape, step)
        else:
            p = np.arange(-1.0, 1.0, 0.004) * np.arcsinh(40.0 / pole)
            q, jacobian = pole * np.sinh(p), pole * np.cosh(p) * (p[1] - p[0])
        weight = jacobian / (2 * (np.cosh(q) + np.cos(np.pi * a)))
        rate = np.exp(np.minimum(q / a, 300.0))
        values[row] = (
            np.sin(np.pi * a) / (np.pi * a) * (np.exp(-np.minimum(np.outer(y, rate), 700.0)) @ weight)
        )
    return _cells(values)


# Polynomial coefficients of a cubic from (f0, f0', f1, f1') on the unit interval.
_HERMITE = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]], dtype=float)


def _cells(values: FloatArray) -> FloatArray:
    """(row cells, column cells, 4, 4) bicubic polynomials through ``values``, derivatives by cubic splines."""
    rows, columns = np.arange(values.shape[0]), np.arange(values.shape[1])
    by_row = CubicSpline(rows, values, axis=0)(rows, 1)
    by_column = CubicSpline(columns, values, axis=1)(columns, 1)
    mixed = CubicSpline(columns, by_row, axis=1)(columns, 1)
    # corner data as (f, f_row) x (f, f_column) at each node, then both ends of the cell in both directions
    node = np.stack([np.stack([values, by_column], -1), np.stack([by_row, mixed], -1)], -2)
    along_row = np.concatenate([node[:-1], node[1:]], axis=-2)
    both = np.concatenate([along_row[:, :-1], along_row[:, 1:]], axis=-1)
    return np.ascontiguousarray(_HERMITE @ both @ _HERMITE.T)


@cache
def tables() -> Tables:
    """The tables of this process."""
    return Tables(contact_table().ravel(), roughness_table().ravel(), relaxation_table().ravel())
