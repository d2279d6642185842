"""A run small enough for a thumbnail: the extremes of each stretch of the recording."""

from __future__ import annotations

import numpy as np

from eaclutch.records import FloatArray, Recording
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.events import find_events
from eaclutch.rig.repair import repair

STRETCHES = 160


def trace(recording: Recording, stretches: int = STRETCHES) -> FloatArray:
    """The repaired run in at most 2 x ``stretches`` points, (points, 3).

    Columns: time [s] (0 = voltage on, or the first sample where no voltage comes on), force [N], and 1 while the
    voltage is on. Of each stretch the smallest and the largest finite force stay, in order of time.
    """
    run = repair(recording)
    finite = np.flatnonzero(np.isfinite(run.force) & np.isfinite(run.time))
    if not len(finite):
        return np.empty((0, 3))
    kept = []
    for part in np.array_split(finite, min(stretches, len(finite))):
        kept += sorted({int(part[np.argmin(run.force[part])]), int(part[np.argmax(run.force[part])])})
    try:
        events = find_events(run)
        start, driven = events.on, (run.time >= events.on) & (run.time < events.off)
    except Unusable:
        start, driven = run.time[finite[0]], np.zeros(len(run.time), dtype=bool)
    return np.column_stack([run.time[kept] - start, run.force[kept], driven[kept]])
