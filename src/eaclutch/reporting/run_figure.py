"""One run at a glance: the whole record with its phases, the rise after voltage on, the fall after voltage off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from eaclutch.records import Recording
from eaclutch.reporting.drawing import BLUE, GREEN, GREY, INK, ORANGE, VERMILION

POINTS = 6000  # drawn of the whole record
AROUND_ON, AROUND_OFF = (-0.015, 0.030), (-0.002, 0.008)  # s
FULL_RATE = 0.2  # s


def run_figure(
    recording: Recording, instants: Mapping[str, float], values: Mapping[str, tuple[float, float]]
) -> Figure:
    """Picture of a repaired recording; the force is as logged, its zero not taken off.

    ``instants``: of ``on``, ``stage_stop``, ``off`` those that are known [s in the run's time]. ``values``: usable
    observables, name to (value, standard uncertainty).
    """
    figure = Figure(figsize=(11, 7), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(3, 2))
    _whole(figure.add_subplot(grid[0, :]), recording, instants)
    rise, fall = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    if {"on", "off"} <= instants.keys():
        _near(rise, recording, instants["on"], AROUND_ON, "time since voltage on (ms)")
        _mark(rise, values.get("engagement_time_s"), "onset", VERMILION, 0)
        _near(fall, recording, instants["off"], AROUND_OFF, "time since voltage off (ms)")
        for line, (share, colour) in enumerate((("10", GREEN), ("50", ORANGE), ("90", VERMILION))):
            _mark(fall, values.get(f"release_time_{share}_s"), f"{share} %", colour, line)
    else:
        for axes in (rise, fall):
            axes.text(0.5, 0.5, "no voltage", ha="center", transform=axes.transAxes, color=GREY)
            axes.set_axis_off()
    return figure


def _whole(axes: Any, recording: Recording, instants: Mapping[str, float]) -> None:
    step = max(1, len(recording.time) // POINTS)
    voltage = axes.twinx()
    voltage.plot(recording.time[::step], recording.voltage[::step], color="0.85", lw=0.5)
    voltage.set_ylabel("sensed voltage (V)", color="0.5")
    axes.set_zorder(voltage.get_zorder() + 1)
    axes.patch.set_visible(False)
    axes.plot(recording.time[::step], recording.force[::step], color=BLUE, lw=0.6)
    top = axes.get_ylim()[1]
    for name, word in (("on", "voltage on"), ("stage_stop", "stage stops"), ("off", "voltage off")):
        if name in instants and not (
            name == "stage_stop" and instants["off"] - instants[name] < FULL_RATE / 2
        ):
            axes.axvline(instants[name], color=INK, lw=0.8, ls=":" if name == "stage_stop" else "-")
            axes.text(instants[name], top, f" {word}", va="top", fontsize=8, color=INK)
    axes.set(xlabel="time (s)", ylabel="force (N)", xlim=(recording.time[0], recording.time[-1]))
    axes.set_title(recording.settings.run, fontsize=9, parse_math=False)


def _near(axes: Any, recording: Recording, event: float, around: tuple[float, float], label: str) -> None:
    since = recording.time - event
    near = (since > around[0]) & (since < around[1])
    axes.plot(since[near] * 1e3, recording.force[near], ".-", ms=3, lw=0.7, color=BLUE)
    axes.axvline(0.0, color=INK, lw=0.8)
    axes.set(xlabel=label, ylabel="force (N)", xlim=np.array(around) * 1e3)


def _mark(axes: Any, value: tuple[float, float] | None, word: str, colour: str, line: int) -> None:
    if value is None:
        return
    at, sd = (1e3 * number for number in value)
    axes.axvline(at, color=colour, lw=1)
    axes.axvspan(at - sd, at + sd, color=colour, alpha=0.2, lw=0)
    low, high = axes.get_ylim()
    axes.text(at, high - (0.03 + 0.07 * line) * (high - low), f" {word}", va="top", fontsize=8, color=colour)
