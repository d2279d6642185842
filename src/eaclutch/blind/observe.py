"""A case at observable level: the table runs as an extractor would write it, and the bench's readings."""

from __future__ import annotations

import numpy as np
import pandas as pd

from eaclutch.blind.case import Case
from eaclutch.blind.clutch import VOLTAGE_ON, force_of
from eaclutch.blind.design import DC, PRELOAD_EDGES, SUBSTRATE
from eaclutch.blind.plan import generator
from eaclutch.blind.reading import OBSERVABLES, ZERO_SD, read_run
from eaclutch.blind.readout import SAMPLE_STEP, readout
from eaclutch.records import FloatArray

GRAVITY = 9.80665
LEAST_FREE = 0.13  # s without contact from which the zero can be read off a run


def runs_table(case: Case) -> pd.DataFrame:
    """runs.csv of the case (contract's columns, then drive_duration_s, dwell_s, run_order), sorted by run."""
    noise = generator(case.entry.namespace, case.entry.seed, "noise")
    rows = []
    for i, settings in enumerate(case.design.settings):
        values, duration = _read(case, i, noise)
        before = values["friction_before_n"][0]
        preload = _preload(before, settings.width, float(case.design.thickness[i]))
        width, thickness = settings.width * 1e3, float(case.design.thickness[i]) * 1e3
        frequency = "DC" if settings.frequency <= DC else f"{settings.frequency:g}Hz"
        row = {
            "run": settings.run,
            "session": case.design.session_names[int(case.design.session[i])],
            "condition": f"{SUBSTRATE}_w{width:g}_t{thickness:g}_{settings.voltage:g}V_{frequency}"
            f"_p{preload_bin(preload)}",
            "substrate": SUBSTRATE,
            "voltage_v": settings.voltage,
            "frequency_hz": settings.frequency,
            "width_mm": round(width, 6),
            "thickness_mm": round(thickness, 6),
            "preload_n": preload,
        }
        for name in OBSERVABLES:
            row[name], row[f"{name}_sd"] = values[name]
        row |= {
            "usable": True,
            "flags": "" if zero_is_known(case, i) else "no_zero",
            "reasons": ";".join(f"{name}:unreadable" for name in OBSERVABLES if np.isnan(values[name][0])),
            "drive_duration_s": duration,
            "dwell_s": float(case.runs.dwell[i]),
            "run_order": int(case.design.order[i]),
        }
        rows.append(row)
    return pd.DataFrame(rows).sort_values("run", ignore_index=True)


def _read(case: Case, i: int, rng: np.random.Generator) -> tuple[dict[str, tuple[float, float]], float]:
    """Observables of run ``i``, and how long its log shows the voltage [s], each end between two samples."""
    runs = case.runs
    on = VOLTAGE_ON + rng.uniform(0, SAMPLE_STEP)
    off = on + float(runs.drive_time[i])
    time = np.arange(on - 0.6, off + 0.15, SAMPLE_STEP) + rng.uniform(0, SAMPLE_STEP)
    force = force_of(case.motion, runs, i, time, on)
    disturbance = case.disturbances[int(runs.session[i])]
    logged = readout(force, time, on, off, off - float(runs.dwell[i]), runs, i, disturbance, rng)
    first = float(time[np.searchsorted(time, on)])
    after = float(time[np.searchsorted(time, off)])
    edge = after - SAMPLE_STEP / 2
    zero_error = rng.normal(0, ZERO_SD)
    known = zero_is_known(case, i)
    found = read_run(
        time,
        logged,
        first,
        edge,
        float(runs.dwell[i]),
        disturbance.zero + zero_error if known else 0.0,
        ZERO_SD if known else 0.0,
    )
    return found, edge - (first - SAMPLE_STEP / 2)


def zero_is_known(case: Case, i: int) -> bool:
    """Whether run ``i`` shows the force without contact; else its zero is not taken off (contract)."""
    return bool(case.free_start[i] > LEAST_FREE)


def _preload(before: float, width: float, thickness: float) -> float:
    """Preload [N] by the paper's eq. for F_preload with the bench's stated coefficients."""
    substrate = (8338.5 * 0.1 * width * thickness + 0.000726) * GRAVITY
    film = 1780 * 24e-6 * 55.5e-3 * width * GRAVITY
    return (before - 0.173 * substrate - 0.154 * film) / (0.154 + 0.173)


def preload_bin(preload: float) -> str:
    """Label of the preload bin, such as 0.25-0.75N."""
    bounds = ["0", *(f"{edge:g}" for edge in PRELOAD_EDGES), "inf"]
    place = int(np.searchsorted(np.asarray(PRELOAD_EDGES), preload, side="right"))
    return f"{bounds[place]}-{bounds[place + 1]}N"


def observable_columns(table: pd.DataFrame) -> tuple[FloatArray, FloatArray]:
    """Values and standard uncertainties of a runs table, each (runs, observables)."""
    values = table[list(OBSERVABLES)].to_numpy(float)
    return values, table[[f"{name}_sd" for name in OBSERVABLES]].to_numpy(float)
