"""Engagement: the time after voltage on until the gap has done a small part of its way."""

from __future__ import annotations

from eaclutch.physics.kernels.compiled import compiled
from eaclutch.physics.kernels.drive import ENGAGING
from eaclutch.physics.kernels.film import net_force_slopes, next_step, rodas_step
from eaclutch.physics.kernels.statics import OK, TIMED_OUT

LATEST = 0.1  # s


@compiled
def engagement_time(p, preload, gap_before, gap_driven, fraction, tolerance, tables):
    """(status, time [s]) until the gap has gone ``fraction`` of the way from without to with voltage."""
    load = preload + p.film_weight
    way = fraction * (gap_before - gap_driven)
    target = gap_before - way
    if p.damping == 0.0:
        return _instant(p, load, gap_before, target, tables)
    t, h, v = 0.0, gap_before, 0.0
    scale = max(p.rise_time_constant, 1e-9)
    dt = 0.1 * scale
    slopes = net_force_slopes(p, 1e-2 * dt, h, v, load, gap_before, ENGAGING, tables)
    for _ in range(2000):
        new_h, new_v, error, _ = rodas_step(p, t, h, v, dt, slopes, load, gap_before, ENGAGING, tables)
        ratio = error / (tolerance * (gap_before - gap_driven))
        if not ratio <= 1.0:
            dt = next_step(dt, ratio) if ratio == ratio else 0.2 * dt
            continue
        if new_h <= target:
            return _locate(p, t, h, v, dt, new_h, new_v, target, slopes, load, gap_before, tables)
        t, h, v = t + dt, new_h, new_v
        if t > LATEST:
            break
        dt = next_step(dt, ratio)
        slopes = net_force_slopes(p, t, h, v, load, gap_before, ENGAGING, tables)
    return TIMED_OUT, LATEST


@compiled
def _locate(p, t, h, v, dt, end_h, end_v, target, slopes, load, gap_before, tables):
    """The crossing inside a step: first by the step's cubic, then by Newton with steps of the method itself."""
    low, high, s = 0.0, 1.0, (h - target) / (h - end_h)
    a, b, drop = v * dt, end_v * dt, end_h - h
    for _ in range(20):  # cubic h + a s + (3 drop - 2 a - b) s^2 + (a + b - 2 drop) s^3
        f = h - target + s * (a + s * (3.0 * drop - 2.0 * a - b + s * (a + b - 2.0 * drop)))
        slope = a + s * (2.0 * (3.0 * drop - 2.0 * a - b) + 3.0 * s * (a + b - 2.0 * drop))
        if f > 0.0:
            low = s
        else:
            high = s
        new = s - f / slope
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - s) < 1e-6:
            s = new
            break
        s = new
    length = s * dt
    for _ in range(4):
        trial_h, trial_v, _, _ = rodas_step(p, t, h, v, length, slopes, load, gap_before, ENGAGING, tables)
        step = (trial_h - target) / trial_v
        length = min(max(length - step, 0.0), dt)
        if abs(step) < 1e-4 * length:
            break
    return OK, t + length


@compiled
def _instant(p, load, gap_before, target, tables):
    """Without damping: the time at which the force balance passes the target gap."""
    low, high = 0.0, 1e-9
    while high < LATEST:
        net, _, _, _ = net_force_slopes(p, high, target, 0.0, load, gap_before, ENGAGING, tables)
        if net < 0.0:
            break
        low, high = high, 2.0 * high
    if high >= LATEST:
        return TIMED_OUT, LATEST
    for _ in range(60):
        middle = 0.5 * (low + high)
        net, _, _, _ = net_force_slopes(p, middle, target, 0.0, load, gap_before, ENGAGING, tables)
        if net < 0.0:
            high = middle
        else:
            low = middle
    return OK, high
