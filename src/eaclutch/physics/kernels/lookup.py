"""Evaluation of the tables: cubic and bicubic Hermite interpolation with derivatives."""

from __future__ import annotations

import math

from numba import njit

from eaclutch.physics.tables import (
    CONTACT_N,
    CONTACT_STEP,
    CONTACT_X0,
    RELAX_ALPHA0,
    RELAX_ALPHA_N,
    RELAX_ALPHA_STEP,
    RELAX_Y0,
    RELAX_Y_N,
    RELAX_Y_STEP,
    ROUGH_A0,
    ROUGH_A_N,
    ROUGH_A_STEP,
    ROUGH_U0,
    ROUGH_U_N,
    ROUGH_U_STEP,
)

ROUGH_U_TOP = ROUGH_U0 + ROUGH_U_STEP * (ROUGH_U_N - 1)


@njit(cache=True, inline="always")
def log_contact(x, table):
    """(log G(x), d log G / dx); linear beyond the table."""
    position = (x - CONTACT_X0) / CONTACT_STEP
    i = int(position)
    if position < 0.0:
        return table[0, 0] + table[0, 1] * (x - CONTACT_X0), table[0, 1]
    if i >= CONTACT_N - 1:
        last = CONTACT_N - 1
        return table[last, 0] + table[last, 1] * (x - CONTACT_X0 - CONTACT_STEP * last), table[last, 1]
    s = position - i
    f0, g0, f1, g1 = table[i, 0], table[i, 1] * CONTACT_STEP, table[i + 1, 0], table[i + 1, 1] * CONTACT_STEP
    c2 = 3.0 * (f1 - f0) - 2.0 * g0 - g1
    c3 = 2.0 * (f0 - f1) + g0 + g1
    return f0 + s * (g0 + s * (c2 + s * c3)), (g0 + s * (2.0 * c2 + 3.0 * s * c3)) / CONTACT_STEP


@njit(cache=True)
def bicubic(table, i, j, s, t):
    """(f, df/ds, df/dt) in cell (i, j) at local coordinates s (rows), t (columns) in [0, 1]."""
    t2, t3 = t * t, t * t * t
    b0, b1 = 1.0 - 3.0 * t2 + 2.0 * t3, 3.0 * t2 - 2.0 * t3
    c0, c1 = t - 2.0 * t2 + t3, t3 - t2
    db0, db1 = 6.0 * (t2 - t), 6.0 * (t - t2)
    dc0, dc1 = 1.0 - 4.0 * t + 3.0 * t2, 3.0 * t2 - 2.0 * t
    p, q = table[i, j], table[i, j + 1]
    r, w = table[i + 1, j], table[i + 1, j + 1]
    f0 = b0 * p[0] + b1 * q[0] + c0 * p[2] + c1 * q[2]
    g0 = b0 * p[1] + b1 * q[1] + c0 * p[3] + c1 * q[3]
    f1 = b0 * r[0] + b1 * w[0] + c0 * r[2] + c1 * w[2]
    g1 = b0 * r[1] + b1 * w[1] + c0 * r[3] + c1 * w[3]
    df0 = db0 * p[0] + db1 * q[0] + dc0 * p[2] + dc1 * q[2]
    dg0 = db0 * p[1] + db1 * q[1] + dc0 * p[3] + dc1 * q[3]
    df1 = db0 * r[0] + db1 * w[0] + dc0 * r[2] + dc1 * w[2]
    dg1 = db0 * r[1] + db1 * w[1] + dc0 * r[3] + dc1 * w[3]
    s2, s3 = s * s, s * s * s
    a0, a1, e0, e1 = 1.0 - 3.0 * s2 + 2.0 * s3, 3.0 * s2 - 2.0 * s3, s - 2.0 * s2 + s3, s3 - s2
    value = a0 * f0 + a1 * f1 + e0 * g0 + e1 * g1
    slope_t = a0 * df0 + a1 * df1 + e0 * dg0 + e1 * dg1
    slope_s = 6.0 * (s2 - s) * (f0 - f1) + (1.0 - 4.0 * s + 3.0 * s2) * g0 + (3.0 * s2 - 2.0 * s) * g1
    return value, slope_s, slope_t


@njit(cache=True)
def rough_kernel(a, u, table):
    """(J, dJ/da, dJ/du) of the averaged force; z^-2 (1 + 3 z^-2 + 15 z^-4 + 105 z^-6) far from the cut."""
    if u >= ROUGH_U_TOP:
        y = 1.0 / (a + u)
        y2 = y * y
        slope = -y2 * y * (2.0 + y2 * (12.0 + y2 * (90.0 + y2 * 840.0)))
        return y2 * (1.0 + y2 * (3.0 + y2 * (15.0 + y2 * 105.0))), slope, slope
    row = (math.log(a) - ROUGH_A0) / ROUGH_A_STEP
    column = (u - ROUGH_U0) / ROUGH_U_STEP
    i = min(max(int(row), 0), ROUGH_A_N - 2)
    j = min(max(int(column), 0), ROUGH_U_N - 2)
    s = min(max(row - i, 0.0), 1.0)
    t = max(column - j, 0.0)
    value, slope_row, slope_column = bicubic(table, i, j, s, t)
    if row < 0.0 or t < 0.0 or row > ROUGH_A_N - 1:  # beyond the edge: straight on in log a
        value += slope_row * (row - i - s)
    j_value = math.exp(value)
    return j_value, j_value * slope_row / (ROUGH_A_STEP * a), j_value * slope_column / ROUGH_U_STEP


@njit(cache=True)
def relaxation(exponent, y, table):
    """(E, y dE/dy) for E = E_alpha(-y^alpha); power laws beyond the table's ends."""
    if y <= 0.0:
        return 1.0, 0.0
    row = (exponent - RELAX_ALPHA0) / RELAX_ALPHA_STEP
    i = min(max(int(row), 0), RELAX_ALPHA_N - 2)
    column = (math.log(y) - RELAX_Y0) / RELAX_Y_STEP
    s = row - i
    if column < 0.0:
        edge, _, _ = bicubic(table, i, 0, s, 0.0)
        short = (1.0 - edge) * math.exp(exponent * column * RELAX_Y_STEP)
        return 1.0 - short, -exponent * short
    if column >= RELAX_Y_N - 1:
        edge, _, _ = bicubic(table, i, RELAX_Y_N - 2, s, 1.0)
        tail = edge * math.exp(-exponent * (column - RELAX_Y_N + 1) * RELAX_Y_STEP)
        return tail, -exponent * tail
    j = int(column)
    value, _, slope = bicubic(table, i, j, s, column - j)
    return value, slope / RELAX_Y_STEP
