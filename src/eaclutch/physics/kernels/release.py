"""Release: film and tip after switch-off, until the tip rests for good."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import compiled
from eaclutch.physics.kernels.contact import contact
from eaclutch.physics.kernels.contact_lag import CAUGHT_UP, late_ends, longest_step
from eaclutch.physics.kernels.drive import RELEASING, electroadhesion, fields_at
from eaclutch.physics.kernels.film import equilibrium, net_force_slopes, next_step, rodas_step
from eaclutch.physics.kernels.forces import tension
from eaclutch.physics.kernels.ramp import train_stiffness
from eaclutch.physics.kernels.slide import COUNT, MODE, X, advance, follow
from eaclutch.physics.kernels.statics import NEVER_SLIPS, OK, TIMED_OUT
from eaclutch.physics.kernels.tip import FREE, STUCK, oscillate, root_of_x

END = 0.11  # s after switch-off: the end of the window that says where the force comes to rest
WINDOW = 0.01  # s; its start


@compiled
def _frictions(p, lift, normal_base):
    """(static, kinetic) [N] at switch-off, kinetic without side friction and weakening."""
    static = (
        p.static_factor_release * (p.base_static * normal_base + p.film_static * lift)
        + p.side_friction_static
    )
    return static, p.base_kinetic * normal_base + p.film_kinetic * lift


@compiled
def _inertia(p, slopes, v, error_v):
    """m_d h'' [N]. The net force is a small difference of large ones and carries the error in v times the damping;
    where that outweighs it, m_d h'' follows the slow forces: (m_d / c) d/dt of them at fixed v."""
    net, by_h, by_v, by_t = slopes
    slow = -p.film_mass / by_v * (by_h * v + by_t)
    noise = by_v * error_v
    apart = net - slow
    return slow + apart * apart * apart / (apart * apart + noise * noise + 1e-300)


@compiled
def _quintic(f, ends, dt, scale, linear_a, linear_b, bulge):
    """f(s) on [0, dt]: ``scale`` x the quintic with the values and slopes ``ends`` = (start, middle, end) of the
    contact force, plus the parabola from linear_a to linear_b whose mean exceeds the straight line's by ``bulge``."""
    a, slope_a, b, slope_b, c, slope_c = ends
    p, q, r = slope_a * dt, slope_b * dt, slope_c * dt
    # the ends' cubic, then s^2 (1 - s)^2 (bend + twist (s - 1/2)) for value and slope in the middle
    cubic_2, cubic_3 = 3.0 * (c - a) - 2.0 * p - r, 2.0 * (a - c) + p + r
    bend = 16.0 * (b - (0.5 * (a + c) + 0.125 * (p - r)))
    twist = 16.0 * (q - (1.5 * (c - a) - 0.25 * (p + r)))
    bend -= 0.5 * twist
    i = 1.0 / dt
    f[0] = scale * a + linear_a
    f[1] = (scale * p + linear_b - linear_a + 6.0 * bulge) * i
    f[2] = (scale * (cubic_2 + bend) - 6.0 * bulge) * i * i
    f[3] = scale * (cubic_3 - 2.0 * bend + twist) * i * i * i
    f[4] = scale * (bend - 2.0 * twist) * i * i * i * i
    f[5] = scale * twist * i * i * i * i * i


@compiled
def fall(p, preload, gap_before, gap_after, gap_driven, switch_off, tolerance, tables, segments, work):
    """(status, segments used, time of rest, force at rest [N]) from the force ``switch_off`` [N] at t = 0;
    ``gap_after`` [m] is where the film comes to rest.

    Times count from the drive's edge (without the drive delay). The film's motion does not depend on the tip's, so
    each film step is followed by the tip over the same span.
    """
    load = preload + p.film_weight
    stiffness = train_stiffness(p)
    state, kinetic, static, spare = work[0], work[1], work[2], work[3]
    state[0], state[1], state[2], state[3] = STUCK, switch_off / stiffness, 0.0, 0.0
    lift_end, _ = contact(p, gap_after, tables)
    static_end, kinetic_end = _frictions(p, lift_end, p.substrate_weight + load)
    static_end = max(static_end, kinetic_end + p.side_friction)
    dynamic = p.load_cell_dynamic != 0.0
    if switch_off <= static_end and p.residual_fraction == 0.0:
        return NEVER_SLIPS, 0, 0.0, switch_off
    damped = p.damping > 0.0
    way = max(gap_before - gap_driven, 1e-9 * p.sigma)
    t, h, v = 0.0, gap_driven, 0.0
    fast = p.fall_time_constant if p.fall_time_constant > 0.0 else 1e-7
    dt = 0.02 * fast
    slopes = net_force_slopes(p, 1e-3 * dt, h, v, load, gap_before, RELEASING, tables)
    lift, slope = contact(p, h, tables)
    lift_rate = 0.0
    lift_driven, late = max(lift, 1e-6), lift  # of the film's friction, what lags
    lag = p.contact_lag * lift_driven**p.contact_lag_power if p.contact_lag_share > 0.0 else 0.0
    inertia = 0.0
    settled = False
    for _ in range(4000):
        if settled:
            dt = END - t
            new_h, new_lift, new_rate, new_inertia = h, lift, 0.0, 0.0
            lift_rate, inertia = 0.0, 0.0
            v, new_v = 0.0, 0.0
        else:
            dt = min(dt, END - t)
            if lag > 0.0:
                dt = min(dt, longest_step(lag, late, lift, lift_driven))
            if damped:
                new_h, new_v, error, error_v = rodas_step(
                    p, t, h, v, dt, slopes, load, gap_before, RELEASING, tables
                )
                ratio = error / (tolerance * way)
                if not ratio <= 1.0:
                    dt = next_step(dt, ratio) if ratio == ratio else 0.2 * dt
                    continue
                slopes = net_force_slopes(p, t + dt, new_h, new_v, load, gap_before, RELEASING, tables)
                new_inertia = _inertia(p, slopes, new_v, error_v)
            else:
                new_h, new_v = equilibrium(p, t + dt, h, load, gap_before, RELEASING, tables)
                ratio = (0.02 * (fast + t) / dt) ** -4 * 0.5 if dt > 0.0 else 0.0
                new_inertia = 0.0
            new_lift, slope = contact(p, new_h, tables)
            new_rate = slope * new_v
        base_a = p.substrate_weight + load + inertia - tension(p, gap_before, h)[0]
        base_b = p.substrate_weight + load + new_inertia - tension(p, gap_before, new_h)[0]
        # the gap in the middle of the step by its cubic; the contact force there is far from one
        mid_h = 0.5 * (h + new_h) + 0.125 * dt * (v - new_v)
        mid_v = 1.5 * (new_h - h) / dt - 0.25 * (v + new_v)
        mid, slope = contact(p, mid_h, tables)
        ends = lift, lift_rate, mid, slope * mid_v, new_lift, new_rate
        new_late = new_lift
        if lag > 0.0:
            ends, new_late = late_ends(ends, late, dt, lag, p.contact_lag_share)
        # the film's momentum says exactly what its inertia adds to the base's friction over the step
        bulge = (
            p.film_mass * (new_v - v) / dt - 0.5 * (inertia + new_inertia) if damped and not settled else 0.0
        )
        _quintic(kinetic, ends, dt, p.film_kinetic, p.base_kinetic * base_a, p.base_kinetic * base_b,
                 p.base_kinetic * bulge)  # fmt: skip
        factor = p.static_factor_release
        _quintic(static, ends, dt, factor * p.film_static,
                 factor * p.base_static * base_a + p.side_friction_static,
                 factor * p.base_static * base_b + p.side_friction_static, factor * p.base_static * bulge)  # fmt: skip
        enough = (
            advance(p, state, segments, t, dt, kinetic, static, spare)
            if dynamic
            else follow(p, state, segments, t, dt, kinetic, static, spare)
        )
        if not enough:
            return TIMED_OUT, int(state[COUNT]), t, stiffness * state[X]
        t, h, v, inertia = t + dt, new_h, new_v, new_inertia
        lift, lift_rate, late = new_lift, new_rate, new_late
        if t >= END * (1.0 - 1e-12):
            break
        if dynamic and int(state[MODE]) == STUCK and state[COUNT] > 0 and stiffness * state[X] <= static_end:
            break  # friction only falls from here on: it rests for good
        if settled and not dynamic:
            break
        if not settled:
            if abs(lift - lift_end) < 1e-7 * lift_end and abs(late - lift_end) < CAUGHT_UP * lift_end:
                lag, late = 0.0, lift
                force = electroadhesion(p, fields_at(p, t, RELEASING, tables), h, tables)
                settled = force < 1e-8 * load
            dt = next_step(dt, ratio)
    n = int(state[COUNT])
    if n == 0:
        return NEVER_SLIPS, 0, 0.0, switch_off
    if int(state[MODE]) == FREE:
        return OK, n, END, p.stiffness * state[X]
    return OK, n, t, stiffness * state[X]


@compiled
def force_at(segments, n, t, start):
    """Reading [N] at t after switch-off; ``start`` before the first segment."""
    low, high = -1, n - 1
    while low < high:
        middle = (low + high + 1) // 2
        if segments[middle, 0] <= t:
            low = middle
        else:
            high = middle - 1
    if low < 0:
        return start
    x, _ = oscillate(segments[low], min(t - segments[low, 0], segments[low, 1]))
    return segments[low, 6] * x


@compiled
def _held(force, begin, end):
    """Integral [N s] of a constant force over the part of [begin, end] inside the window."""
    return force * max(min(end, END) - max(begin, WINDOW), 0.0)


@compiled
def final_force(segments, n, rest_time, rest_force, start):
    """Mean reading [N] over 10 .. 110 ms after switch-off: the rest level, or the mean of what still moves."""
    if rest_time <= WINDOW:
        return rest_force
    total = _held(start, 0.0, segments[0, 0] if n > 0 else END)
    for i in range(n):
        segment = segments[i]
        begin, length, stiffness = segment[0], segment[1], segment[6]
        low, high = max(WINDOW - begin, 0.0), min(END - begin, length)
        if high > low:  # Simpson over parts of the oscillator's period
            parts = min(int((high - low) * math.sqrt(abs(segment[5])) / 0.4), 50) + 1
            step = (high - low) / parts
            for j in range(parts):
                s = low + j * step
                a, _ = oscillate(segment, s)
                b, _ = oscillate(segment, s + 0.5 * step)
                c, _ = oscillate(segment, s + step)
                total += stiffness * (a + 4.0 * b + c) * step / 6.0
        end, _ = oscillate(segment, length)
        total += _held(stiffness * end, begin + length, segments[i + 1, 0] if i + 1 < n else END)
    return total / (END - WINDOW)


@compiled
def crossing(segments, n, level):
    """Time [s] at which the reading first falls to ``level`` [N]; NaN if it does not."""
    for i in range(n):
        segment = segments[i]
        stiffness = segment[6]
        target = level / stiffness
        start, _ = oscillate(segment, 0.0)
        if start <= target:
            return segment[0]
        end, _ = oscillate(segment, segment[1])
        if end <= target:
            return segment[0] + root_of_x(segment, target, 0.0, segment[1])
    return math.nan
