"""Engagement: the time after voltage on until the gap has done a small part of its way."""

from __future__ import annotations

from numba import njit

from eaclutch.physics.kernels.film import net_force_slopes, next_step, rodas_step
from eaclutch.physics.kernels.forces import ENGAGING
from eaclutch.physics.kernels.statics import OK, TIMED_OUT

LATEST = 0.1  # s


@njit(cache=True)
def engagement_time(p, preload, gap_before, gap_driven, fraction, tolerance, tables):
    """(status, time [s]) until the gap has gone ``fraction`` of the way from without to with voltage."""
    load = preload + p.film_weight
    way = fraction * (gap_before - gap_driven)
    target = gap_before - way
    if p.damping == 0.0:
        return _instant(p, load, gap_before, target, tables)
    t, h, v = 0.0, gap_before, 0.0
    scale = max(p.rise_time_constant, 1e-9)
    dt = 0.02 * scale
    slopes = net_force_slopes(p, 1e-3 * dt, h, v, load, gap_before, ENGAGING, tables)
    for _ in range(2000):
        new_h, new_v, error = rodas_step(p, t, h, v, dt, slopes, load, gap_before, ENGAGING, tables)
        ratio = error / (tolerance * way)
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


@njit(cache=True)
def _locate(p, t, h, v, dt, end_h, end_v, target, slopes, load, gap_before, tables):
    """The crossing inside a step: bracketed secant on the step length, each trial a step of the method itself."""
    low, low_f, high, high_f = 0.0, h - target, dt, end_h - target
    length, length_v = dt, end_v
    f = high_f
    for _ in range(30):
        # Newton from the last trial, kept inside the bracket
        trial = length - f / length_v if length_v < 0.0 else 0.5 * (low + high)
        if not low < trial < high:
            trial = low + (high - low) * low_f / (low_f - high_f)
        h_trial, length_v, _ = rodas_step(p, t, h, v, trial, slopes, load, gap_before, ENGAGING, tables)
        f, length = h_trial - target, trial
        if f > 0.0:
            low, low_f = trial, f
        else:
            high, high_f = trial, f
        if abs(f) < 1e-9 * (gap_before - target):
            break
    return OK, t + length


@njit(cache=True)
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
