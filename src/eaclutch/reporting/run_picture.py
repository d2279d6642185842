"""The picture of one run, for whoever stands at the rig."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from eaclutch.records import Recording


def run_picture(recording: Recording, caption: str = "") -> Figure:
    """Force and sensed voltage over the whole run, and the force around the end of the drive."""
    time, driven = recording.time, np.flatnonzero(recording.flag > 0.5)
    figure = Figure(figsize=(9, 5), layout="constrained")
    whole, end = figure.subplots(1, 2, width_ratios=(3, 2))
    step = max(1, len(time) // 6000)
    voltage = whole.twinx()
    voltage.plot(time[::step], recording.voltage[::step], color="0.8", lw=0.5)
    voltage.set_ylabel("sensed voltage (V)", color="0.5")
    whole.set_zorder(voltage.get_zorder() + 1)
    whole.patch.set_visible(False)
    whole.plot(time[::step], recording.force[::step], lw=0.7)
    whole.set(xlabel="time (s)", ylabel="force (N)", title=recording.settings.run, xlim=(time[0], time[-1]))
    whole.title.set(fontsize=7, parse_math=False)
    if len(driven):
        last = time[driven[-1]]
        near = np.abs(time - last) < 0.015
        end.plot((time[near] - last) * 1e3, recording.force[near], ".-", ms=3, lw=0.7)
        end.axvline(0.0, color="0.7", lw=1)
    end.set(xlabel="time since the flag fell (ms)", ylabel="force (N)")
    end.set_title(caption, fontsize=7, parse_math=False)
    return figure
