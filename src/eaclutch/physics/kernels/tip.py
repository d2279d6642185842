"""The load cell's tip between film steps: a damped oscillator with friction, solved exactly.

Modes: stuck, sliding back (friction pushes forward), sliding forward, free (x <= 0: the tip cannot pull). Within a
film step the friction is a quintic in time, so x is a damped sinusoid plus a quintic; velocity zeros and the
contact's loss and return are located as roots of that expression. Segments are kept so that crossings of any
force level can be found afterwards.
"""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import compiled

STUCK, BACK, FORWARD, FREE, FOLLOW = 0, 1, 2, 3, 4
SEGMENTS, COLUMNS = 2048, 17  # t0, length, A, B, beta, omega^2, stiffness, q0..q9
SHORT = 0.1  # rad; a shorter segment is a power series: its sinusoid and forced part would cancel to nothing
STEP_PHASE = 0.7  # rad of the oscillator a segment may last, so that no event is jumped over


@compiled
def oscillate(segment, s):
    """(x, v) at s after the segment's start."""
    q1, q2, q3, q4, q5 = segment[8], segment[9], segment[10], segment[11], segment[12]
    a, b, beta, omega2 = segment[2], segment[3], segment[4], segment[5]
    if a == 0.0 and b == 0.0:
        q6, q7, q8, q9 = segment[13], segment[14], segment[15], segment[16]
        high = q6 + s * (q7 + s * (q8 + s * q9))
        x = segment[7] + s * (q1 + s * (q2 + s * (q3 + s * (q4 + s * (q5 + s * high)))))
        high = 6.0 * q6 + s * (7.0 * q7 + s * (8.0 * q8 + 9.0 * s * q9))
        return x, q1 + s * (2.0 * q2 + s * (3.0 * q3 + s * (4.0 * q4 + s * (5.0 * q5 + s * high))))
    if omega2 > 0.0:
        omega = math.sqrt(omega2)
        decay = math.exp(-beta * s)
        c, d = decay * math.cos(omega * s), decay * math.sin(omega * s) / omega
    elif omega2 < 0.0:  # overdamped: two exponentials, the slow one's rate without cancellation
        omega = math.sqrt(-omega2)
        slow, quick = math.exp(-(omega2 + beta * beta) / (beta + omega) * s), math.exp(-(beta + omega) * s)
        c, d = 0.5 * (slow + quick), 0.5 * (slow - quick) / omega
    else:
        decay = math.exp(-beta * s)
        c, d = decay, decay * s
    x = a * c + b * d
    v = b * c - omega2 * a * d - beta * x
    x += segment[7] + s * (q1 + s * (q2 + s * (q3 + s * (q4 + s * q5))))
    v += q1 + s * (2.0 * q2 + s * (3.0 * q3 + s * (4.0 * q4 + 5.0 * s * q5)))
    return x, v


@compiled
def set_segment(segment, t0, length, x, v, mass, damping, stiffness, f, sign):
    """Fill ``segment`` with the solution of m x'' + b x' + k x = sign (f0 + f1 s + .. + f5 s^5) from (x, v)."""
    beta = 0.5 * damping / mass
    w = stiffness / mass
    segment[0], segment[1], segment[4], segment[5], segment[6] = t0, length, beta, w - beta * beta, stiffness
    if max(w * length * length, beta * beta * length * length) < SHORT * SHORT:
        segment[2], segment[3], segment[7], segment[8] = 0.0, 0.0, x, v
        for k in range(8):
            force = sign * f[k] / mass if k < 6 else 0.0
            rate = force - 2.0 * beta * (k + 1) * segment[8 + k] - w * segment[7 + k]
            segment[9 + k] = rate / ((k + 1) * (k + 2))
        return
    scale = sign / stiffness
    lag, lead = 2.0 * beta / w, 1.0 / w
    q5 = scale * f[5]
    q4 = scale * f[4] - 5.0 * lag * q5
    q3 = scale * f[3] - 4.0 * lag * q4 - 20.0 * lead * q5
    q2 = scale * f[2] - 3.0 * lag * q3 - 12.0 * lead * q4
    q1 = scale * f[1] - 2.0 * lag * q2 - 6.0 * lead * q3
    q0 = scale * f[0] - lag * q1 - 2.0 * lead * q2
    segment[7], segment[8], segment[9], segment[10], segment[11], segment[12] = q0, q1, q2, q3, q4, q5
    segment[2] = x - q0
    segment[3] = v - q1 + beta * (x - q0)


@compiled
def root_of_x(segment, target, low, high):
    """s in [low, high] with x(s) = target; x - target changes sign over it (Newton kept in a bracket)."""
    x_low, _ = oscillate(segment, low)
    sign = 1.0 if x_low > target else -1.0
    s = 0.5 * (low + high)
    for _ in range(60):
        x, v = oscillate(segment, s)
        f = (x - target) * sign
        if f > 0.0:
            low = s
        else:
            high = s
        new = s - (x - target) / v if v != 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - s) < 1e-15 + 1e-13 * segment[1]:
            return new
        s = new
    return s


@compiled
def root_of_v(segment, sign, low, high):
    """s in (low, high] at which sign v turns from negative to positive (Illinois)."""
    _, v_high = oscillate(segment, high)
    f_high = sign * v_high
    _, v_low = oscillate(segment, low)
    f_low = min(sign * v_low, -1e-300)
    for _ in range(100):
        s = (low * f_high - high * f_low) / (f_high - f_low)
        if not low < s < high or s - low < 1e-3 * (high - low):
            s = 0.5 * (low + high)
        _, v = oscillate(segment, s)
        f = sign * v
        if f > 0.0:
            high, f_high = s, f
            f_low *= 0.5
        else:
            low, f_low = s, min(f, -1e-300)
            f_high *= 0.5
        if high - low < 1e-13 * segment[1] + 1e-16:
            break
    return high
