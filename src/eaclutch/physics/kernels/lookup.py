"""Evaluation of the tables: a cell's polynomial, with its slopes where they are asked for."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import inlined
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

CONTACT_RATE = 1.0 / CONTACT_STEP
ROUGH_A_RATE, ROUGH_U_RATE = 1.0 / ROUGH_A_STEP, 1.0 / ROUGH_U_STEP
RELAX_ALPHA_RATE, RELAX_Y_RATE = 1.0 / RELAX_ALPHA_STEP, 1.0 / RELAX_Y_STEP
# Numbers from one row of cells to the next in the flat tables (flat: no views are made while solving).
ROUGH_CELLS, RELAX_CELLS = 16 * (ROUGH_U_N - 1), 16 * (RELAX_Y_N - 1)
ROUGH_U_TOP = ROUGH_U0 + ROUGH_U_STEP * (ROUGH_U_N - 1)


@inlined
def log_contact(x, table):
    """(log G(x), d log G / dx); straight on beyond the table."""
    position = (x - CONTACT_X0) * CONTACT_RATE
    i = min(max(int(position), 0), CONTACT_N - 2)
    k = 4 * i
    s = min(max(position - i, 0.0), 1.0)
    c1, c2, c3 = table[k + 1], table[k + 2], table[k + 3]
    slope = c1 + s * (2.0 * c2 + 3.0 * s * c3)
    return table[k] + s * (c1 + s * (c2 + s * c3)) + slope * (position - i - s), slope * CONTACT_RATE


@inlined
def cell_value(table, k, s, t):
    """Bicubic polynomial of the cell that starts at ``table[k]`` at (s, t)."""
    a = table[k] + t * (table[k + 1] + t * (table[k + 2] + t * table[k + 3]))
    b = table[k + 4] + t * (table[k + 5] + t * (table[k + 6] + t * table[k + 7]))
    c = table[k + 8] + t * (table[k + 9] + t * (table[k + 10] + t * table[k + 11]))
    d = table[k + 12] + t * (table[k + 13] + t * (table[k + 14] + t * table[k + 15]))
    return a + s * (b + s * (c + s * d))


@inlined
def cell_slopes(table, k, s, t):
    """(value, d/ds, d/dt) of the bicubic polynomial of the cell at ``table[k]``."""
    a = table[k] + t * (table[k + 1] + t * (table[k + 2] + t * table[k + 3]))
    b = table[k + 4] + t * (table[k + 5] + t * (table[k + 6] + t * table[k + 7]))
    c = table[k + 8] + t * (table[k + 9] + t * (table[k + 10] + t * table[k + 11]))
    d = table[k + 12] + t * (table[k + 13] + t * (table[k + 14] + t * table[k + 15]))
    e = table[k + 1] + t * (2.0 * table[k + 2] + 3.0 * t * table[k + 3])
    f = table[k + 5] + t * (2.0 * table[k + 6] + 3.0 * t * table[k + 7])
    g = table[k + 9] + t * (2.0 * table[k + 10] + 3.0 * t * table[k + 11])
    h = table[k + 13] + t * (2.0 * table[k + 14] + 3.0 * t * table[k + 15])
    return a + s * (b + s * (c + s * d)), b + s * (2.0 * c + 3.0 * s * d), e + s * (f + s * (g + s * h))


@inlined
def rough_row(a):
    """(row cell, coordinate in it) of the cut a; beyond the table the coordinate runs on."""
    row = (math.log(a) - ROUGH_A0) * ROUGH_A_RATE
    i = min(max(int(row), 0), ROUGH_A_N - 2)
    return i, row - i


@inlined
def rough_value(a, i, s, u, table):
    """J(a, u) with (i, s) = rough_row(a); z^-2 (1 + 3 z^-2 + 15 z^-4 + 105 z^-6) far from the cut."""
    if u >= ROUGH_U_TOP:
        y = 1.0 / ((a + u) * (a + u))
        return y * (1.0 + y * (3.0 + y * (15.0 + y * 105.0)))
    if s < 0.0 or s > 1.0:
        return rough_slopes(a, i, s, u, table)[0]
    column = max((u - ROUGH_U0) * ROUGH_U_RATE, 0.0)
    j = int(column)
    return math.exp(cell_value(table, ROUGH_CELLS * i + 16 * j, s, column - j))


@inlined
def rough_slopes(a, i, s, u, table):
    """(J, dJ/da, dJ/du)."""
    if u >= ROUGH_U_TOP:
        z = 1.0 / (a + u)
        y = z * z
        slope = -y * z * (2.0 + y * (12.0 + y * (90.0 + y * 840.0)))
        return y * (1.0 + y * (3.0 + y * (15.0 + y * 105.0))), slope, slope
    column = max((u - ROUGH_U0) * ROUGH_U_RATE, 0.0)
    j = int(column)
    inside = min(max(s, 0.0), 1.0)
    log_j, by_row, by_column = cell_slopes(table, ROUGH_CELLS * i + 16 * j, inside, column - j)
    j_value = math.exp(log_j + by_row * (s - inside))  # straight on in log a beyond the table
    return j_value, j_value * by_row * ROUGH_A_RATE / a, j_value * by_column * ROUGH_U_RATE


@inlined
def relaxation(exponent, y, table):
    """(E, y dE/dy) for E = E_alpha(-y^alpha); power laws beyond the table's ends."""
    if y <= 0.0:
        return 1.0, 0.0
    row = (exponent - RELAX_ALPHA0) * RELAX_ALPHA_RATE
    i = min(max(int(row), 0), RELAX_ALPHA_N - 2)
    s = row - i
    column = (math.log(y) - RELAX_Y0) * RELAX_Y_RATE
    if column < 0.0:
        short = (1.0 - cell_value(table, RELAX_CELLS * i, s, 0.0)) * math.exp(
            exponent * column * RELAX_Y_STEP
        )
        return 1.0 - short, -exponent * short
    if column >= RELAX_Y_N - 1:
        edge = cell_value(table, RELAX_CELLS * i + 16 * (RELAX_Y_N - 2), s, 1.0)
        tail = edge * math.exp(-exponent * (column - RELAX_Y_N + 1) * RELAX_Y_STEP)
        return tail, -exponent * tail
    j = int(column)
    value, _, slope = cell_slopes(table, RELAX_CELLS * i + 16 * j, s, column - j)
    return value, slope * RELAX_Y_RATE
