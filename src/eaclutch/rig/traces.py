"""A run's force thinned for drawing: the extremes of each stretch are kept."""

from __future__ import annotations

import itertools

import numpy as np

from eaclutch.records import FloatArray, Recording
from eaclutch.rig.estimate import Unusable
from eaclutch.rig.events import find_events

POINTS = 400


def trace(recording: Recording, points: int = POINTS) -> FloatArray:
    """Shape (<= points, 3): time from voltage on [s] (from the start where there was none), force [N], voltage on.

    Of every stretch the smallest and the largest force are kept, so that a slip or a spike stays visible.
    """
    good = np.isfinite(recording.time) & np.isfinite(recording.force)
    time, force = recording.time[good], recording.force[good]
    try:
        events = find_events(recording)
        driven = (time > events.on) & (time < events.off)
        time = time - events.on
    except Unusable:
        driven = np.zeros(len(time), dtype=bool)
    if len(time) <= points:
        index = np.arange(len(time))
    else:
        edges = np.linspace(0, len(time), points // 2 + 1).astype(int)
        pairs = [
            (start + int(np.argmin(force[start:end])), start + int(np.argmax(force[start:end])))
            for start, end in itertools.pairwise(edges)
        ]
        index = np.unique(np.array(pairs).ravel())
    return np.stack([time[index], force[index], driven[index].astype(float)], axis=1)
