"""What an amplifier with a low pass logs of a release."""

from __future__ import annotations

import math

from eaclutch.physics.kernels.compiled import compiled
from eaclutch.physics.kernels.release import END, crossing, force_at

STEP = 1e-5  # s; a tip swings by 0.04 rad within it


@compiled
def lagged(before, after, read, step, time_constant):
    """Reading at the end of a ``step`` in which the force goes straight from ``before`` to ``after``, behind a low pass
    that read ``read`` at its start."""
    behind = (after - before) / step * time_constant
    return after - behind + (read - before + behind) * math.exp(-step / time_constant)


@compiled
def read_crossings(p, segments, n, start, levels, times):
    """Times [s] at which the reading first falls to each of ``levels`` [N], from the highest down; NaN where it does
    not."""
    times[:] = math.nan
    if p.readout_time <= 0.0:
        for i in range(len(levels)):
            times[i] = crossing(segments, n, levels[i])
        return
    t, force, read, i = 0.0, start, start, 0
    while t < END and i < len(levels):
        new_force = force_at(segments, n, t + STEP, start)
        new_read = lagged(force, new_force, read, STEP, p.readout_time)
        while i < len(levels) and new_read <= levels[i]:
            times[i] = t + STEP * (read - levels[i]) / (read - new_read)
            i += 1
        t, force, read = t + STEP, new_force, new_read
