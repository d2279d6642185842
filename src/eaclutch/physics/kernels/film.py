"""The film's motion m_d h'' = F_k + F_b - F_ea - ... by Rodas4: a linearly implicit, L-stable, stiffly accurate
method of order 4(3) (Hairer & Wanner, Solving ODEs II, 1996, IV.7) on the 2x2 system (h, v), adaptive, the error
measured against the film's whole displacement. Where nothing damps the film it follows its equilibrium."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import compiled, inlined
from eaclutch.physics.kernels.contact import adhesion, contact
from eaclutch.physics.kernels.drive import electroadhesion, electroadhesion_slopes, fields_at
from eaclutch.physics.kernels.forces import squeeze, tension

GAMMA = 0.25
A21 = 1.544000000000000
A31, A32 = 0.9466785280815826, 0.2557011698983284
A41, A42, A43 = 3.314825187068521, 2.896124015972201, 0.9986419139977817
A51, A52, A53, A54 = 1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950
C21 = -5.6688
C31, C32 = -2.430093356833875, -0.2063599157091915
C41, C42, C43 = -0.1073529058151375, -9.594562251023355, -20.47028614809616
C51, C52, C53, C54 = 7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160
C61, C62, C63 = 8.083246795921522, -7.981132988064893, -31.52159432874371
C64, C65 = 16.31930543123136, -6.058818238834054
D1, D2, D3, D4 = 0.25, -0.1043, 0.1035, -0.0362
T2, T3, T4 = 0.386, 0.21, 0.63


@inlined
def net_force(p, fields, h, v, load, gap_before, tables):
    """Net upward force on the film [N] in the fields of that instant."""
    up, _ = contact(p, h, tables)
    down = electroadhesion(p, fields, h, tables)
    pull, _ = adhesion(p, h, tables)
    c, _ = squeeze(p, h, tables)
    held, _ = tension(p, gap_before, h)
    return up - down - pull - load + held - c * v


@inlined
def net_force_slopes(p, t, h, v, load, gap_before, phase, tables):
    """(net force, d/dh, d/dv, d/dt)."""
    up, up_h = contact(p, h, tables)
    down, down_h, down_t = electroadhesion_slopes(p, t, phase, h, tables)
    pull, pull_h = adhesion(p, h, tables)
    c, c_h = squeeze(p, h, tables)
    held, stiff = tension(p, gap_before, h)
    net = up - down - pull - load + held - c * v
    return net, up_h - down_h - pull_h - stiff - c_h * v, -c, -down_t


@inlined
def _solve(determinant, g, gv, fh, r1, r2):
    """(k_h, k_v) of the 2x2 system [[g, -1], [-fh, gv]] k = r, gv = g - fv."""
    return (r1 * gv + r2) / determinant, (g * r2 + fh * r1) / determinant


@compiled
def rodas_step(p, t, h, v, dt, slopes, load, gap_before, phase, tables):
    """(h, v, error in h, error in v) after one step; ``slopes`` = net_force_slopes at (t, h, v)."""
    inverse_mass = 1.0 / p.film_mass
    f0, fh, fv, ft = slopes[0] * inverse_mass, slopes[1] * inverse_mass, slopes[2] * inverse_mass, slopes[3]
    ft *= inverse_mass
    g = 1.0 / (GAMMA * dt)
    gv = g - fv
    determinant = g * gv - fh
    i = 1.0 / dt
    h1, v1 = _solve(determinant, g, gv, fh, v, f0 + D1 * dt * ft)

    a, b = h + A21 * h1, v + A21 * v1
    fields = fields_at(p, t + T2 * dt, phase, tables)
    f = net_force(p, fields, a, b, load, gap_before, tables) * inverse_mass
    h2, v2 = _solve(determinant, g, gv, fh, b + C21 * h1 * i, f + C21 * v1 * i + D2 * dt * ft)

    a, b = h + A31 * h1 + A32 * h2, v + A31 * v1 + A32 * v2
    fields = fields_at(p, t + T3 * dt, phase, tables)
    f = net_force(p, fields, a, b, load, gap_before, tables) * inverse_mass
    h3, v3 = _solve(
        determinant, g, gv, fh, b + (C31 * h1 + C32 * h2) * i, f + (C31 * v1 + C32 * v2) * i + D3 * dt * ft
    )

    a, b = h + A41 * h1 + A42 * h2 + A43 * h3, v + A41 * v1 + A42 * v2 + A43 * v3
    fields = fields_at(p, t + T4 * dt, phase, tables)
    f = net_force(p, fields, a, b, load, gap_before, tables) * inverse_mass
    h4, v4 = _solve(
        determinant, g, gv, fh,
        b + (C41 * h1 + C42 * h2 + C43 * h3) * i, f + (C41 * v1 + C42 * v2 + C43 * v3) * i + D4 * dt * ft,
    )  # fmt: skip

    a = h + A51 * h1 + A52 * h2 + A53 * h3 + A54 * h4
    b = v + A51 * v1 + A52 * v2 + A53 * v3 + A54 * v4
    fields = fields_at(p, t + dt, phase, tables)
    f = net_force(p, fields, a, b, load, gap_before, tables) * inverse_mass
    h5, v5 = _solve(
        determinant, g, gv, fh,
        b + (C51 * h1 + C52 * h2 + C53 * h3 + C54 * h4) * i, f + (C51 * v1 + C52 * v2 + C53 * v3 + C54 * v4) * i,
    )  # fmt: skip

    a += h5
    b += v5
    f = net_force(p, fields, a, b, load, gap_before, tables) * inverse_mass
    h6, v6 = _solve(
        determinant, g, gv, fh,
        b + (C61 * h1 + C62 * h2 + C63 * h3 + C64 * h4 + C65 * h5) * i,
        f + (C61 * v1 + C62 * v2 + C63 * v3 + C64 * v4 + C65 * v5) * i,
    )  # fmt: skip
    return a + h6, b + v6, abs(h6), abs(v6)


@compiled
def equilibrium(p, t, h, load, gap_before, phase, tables):
    """(h, dh/dt) where the forces balance at time t, from a start near it: the film without damping."""
    fh, ft = -1.0, 0.0
    for _ in range(40):
        net, fh, _, ft = net_force_slopes(p, t, h, 0.0, load, gap_before, phase, tables)
        # Newton on the logarithm of the contact, the steep part
        up, _ = contact(p, h, tables)
        weight = up * math.log(max(up / max(up - net, 1e-3 * up), 1e-3))
        step = weight / fh if fh < 0.0 else -0.05 * p.sigma
        step = min(max(step, -0.5 * p.sigma), 0.5 * p.sigma)
        h = h - step
        if abs(step) < 1e-12 * p.sigma:
            break
    return h, -ft / fh


@inlined
def next_step(dt, error):
    """Step size after a step with this error ratio (order 4: fourth root), within [0.2, 5] of the last."""
    return dt * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** -0.25))
