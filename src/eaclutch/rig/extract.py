"""A run's row of runs.csv: every observable with its uncertainty, and what was wrong."""

from __future__ import annotations

from typing import Any

import numpy as np

from eaclutch.records import Bench, Recording
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables import OBSERVABLES
from eaclutch.rig.preload import preload_of
from eaclutch.rig.repair import make_whole
from eaclutch.rig.run_view import RunView
from eaclutch.rig.table import empty_row


def extract(recording: Recording, bench: Bench) -> dict[str, Any]:
    """One row of a batch table from a recording as logged; see ``extract_view``."""
    return extract_view(recording, bench)[1]


def extract_view(
    recording: Recording, bench: Bench, finishes: bool | None = None
) -> tuple[RunView, dict[str, Any]]:
    """The repaired run and its row of a batch table, from a recording as logged; ``finishes``: whether other runs say
    that the drive finishes its half waves, where they do.

    Keys of the row: run, settings (voltage_v, frequency_hz, width_mm, substrate), drive_duration_s, dwell_s, preload_n,
    ``<observable>`` and ``<observable>_sd`` (NaN where unusable), slip_fraction_sd_zero_known, usable, flags (joined
    by ``;``).
    """
    run = RunView(make_whole(recording, finishes), finishes)
    flags = list(run.whole.recording.flags)
    estimates = {}
    for name, observable in OBSERVABLES.items():
        try:
            estimates[name] = observable.measure(run)
        except Unusable as reason:
            estimates[name] = Estimate.missing(str(reason))
    row = empty_row(recording.settings.run)
    try:
        events = run.events
        flags.append(run.zero.reason)
        flags += events.flags
        row |= {"drive_duration_s": events.drive_duration, "dwell_s": events.dwell}
    except Unusable as reason:
        flags.append(str(reason))
    settings = recording.settings
    estimated = preload_of(estimates["friction_before_n"].value, settings, bench)
    row["preload_n"] = estimated if settings.preload is None else settings.preload
    for name, estimate in estimates.items():
        row[name], row[f"{name}_sd"] = estimate.value, estimate.sd
        if estimate.sd_zero_known is not None:
            row[f"{name}_sd_zero_known"] = estimate.sd_zero_known
    usable = [name for name, estimate in estimates.items() if estimate.usable]
    row["usable"] = bool(np.isin(["shear_capacity_n", "release_time_90_s"], usable).any())
    flags += [estimate.flag for estimate in estimates.values()]
    row["flags"] = ";".join(sorted(set(filter(None, flags))))
    row["reasons"] = ";".join(f"{name}:{e.reason}" for name, e in estimates.items() if e.reason)
    return run, row
