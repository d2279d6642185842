"""How often the extractor's intervals hold the truth, on simulated runs whose noiseless force is known."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d

from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, Recording
from eaclutch.rig.columns_in_step import sample_spacing
from eaclutch.rig.extract import extract
from eaclutch.rig.observables import OBSERVABLES
from eaclutch.rig.observables.hold import CREEP_WINDOW, SHORTEST_CREEP, STAGE_SETTLING
from eaclutch.rig.observables.ringdown import END, START
from eaclutch.rig.observables.slip import CLEAR, DURATION
from eaclutch.rig.swing import fit_swing
from eaclutch.simulation.campaign import conditions_of, settings_of
from eaclutch.simulation.drive_signal import clock, half_wave
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.plan import Plan, PlannedRun, RecordTiming
from eaclutch.simulation.run import record_run

VOLTAGES = (150.0, 200.0, 250.0, 300.0)
FREQUENCIES = (0.1, 1.0, 10.0, 100.0, 1000.0, 5000.0)
PRELOADS = (0.1, 0.5, 1.0)  # N
# Forces that keep a zero that a run does not show.
ABSOLUTE = ("friction_before_n", "switch_off_force_n", "final_force_n")
FIRST_RUN = datetime(2030, 1, 1, 9)


def clean_noise(noise: BenchNoise) -> BenchNoise:
    """The same bench with nothing added to the force; what scatters from run to run and slip to slip stays."""
    quiet = replace(noise, white=0.0, mains_amplitude=0.0, lines=(), force_count=0.0)
    return replace(quiet, pickup=0.0, pickup_rising=0.0, pickup_falling=0.0)


def truth_of(clean: Recording, on: float, off: float, stage_stop: float, noise_sd: float) -> dict[str, float]:
    """The observables of a noiseless recording by their definitions, the instants [s] being known exactly.

    ``noise_sd`` [N]: one sample's noise in the recording it is compared with, which says what counts as a swing.
    """
    time, force = clean.time, clean.force

    def mean(start: float, end: float) -> float:
        return float(force[(time >= start) & (time < end)].mean())

    def slope(start: float, end: float) -> float:
        picked = (time >= start) & (time < end)
        return float(np.polyfit(time[picked] - start, force[picked], 1)[0])

    driven = (time >= on) & (time < off)
    friction, before, final = mean(on - 0.5, on), mean(on - 0.02, on), mean(off + 0.01, off + 0.11)
    held = float(np.median(force[(time >= off - 0.003) & (time < off)]))
    rising = np.flatnonzero((time > on) & (force > force[(time < on)][-1] + 5e-4))
    found = {
        "friction_before_n": friction,
        "engagement_time_s": float(time[rising[0]] - on) if len(rising) else np.nan,
        "ramp_rate_n_s": slope(on + 0.002, on + 0.020),
        "ramp_rate_early_n_s": slope(on + 0.0005, on + 0.005),
        "ramp_rate_late_n_s": slope(on + 0.05, on + 0.2),
        "shear_capacity_n": float(uniform_filter1d(force[driven], 20)[20:-20].max()) - before,
        "switch_off_force_n": held,
        "final_force_n": final,
        "baseline_shift_n": final - friction,
    }
    found["start_ratio"] = (held - final) / (found["shear_capacity_n"] + friction - final)
    after = (time >= off - 0.002) & (time < off + 0.03)
    stop = max(off - CREEP_WINDOW, stage_stop + STAGE_SETTLING)
    if off - stop >= SHORTEST_CREEP:
        found["hold_creep_n_s"] = slope(stop, off)
    pushed = force[(time >= on + CLEAR) & (time < off - CLEAR)]
    ahead = round(DURATION / sample_spacing(time))
    drops = pushed[:-ahead] - np.lib.stride_tricks.sliding_window_view(pushed[1:], ahead).min(axis=1)
    found["slip_fraction"] = float(drops.max() / pushed[np.argmax(drops)])
    ringing = (time >= off + START) & (time < off + END)
    swing = fit_swing(time[ringing], force[ringing], noise_sd)
    if swing is not None:
        found["ringdown_frequency_hz"], found["ringdown_damping_ratio"] = swing.frequency, swing.damping_ratio
    fine = np.arange(off, off + 0.02, 1e-6)
    falling = CubicSpline(time[after], force[after])(fine)
    for share in (0.1, 0.5, 0.9):
        below = np.flatnonzero(falling < held - share * (held - final))
        found[f"release_time_{share * 100:g}_s"] = float(fine[below[0]] - off) if len(below) else np.nan
    return found


def compare(
    count: int,
    bench: Bench,
    noise: BenchNoise,
    rng: np.random.Generator,
    parameters: Mapping[str, float] | None = None,
    preloads: Sequence[float] = PRELOADS,
) -> pd.DataFrame:
    """A row a run and observable: run, observable, truth, value, sd. ``count`` runs over voltages, frequencies,
    ``preloads`` [N] and the bench's widths; those without a clean release or rise give no truth for it.
    ``parameters``: of the model, where they are not its defaults."""
    model, timing = ClutchModel(bench), RecordTiming()
    widths = sorted({width for substrate in bench.substrates.values() for width in substrate.thickness})
    substrate = next(iter(bench.substrates))
    values = {name: float(parameter.default) for name, parameter in model.parameters.items()}
    values |= parameters or {}
    planned = tuple(
        PlannedRun(
            FIRST_RUN + timedelta(minutes=i),
            float(rng.choice(VOLTAGES)),
            float(rng.choice(FREQUENCIES)),
            float(rng.choice(widths)),
            float(rng.choice(preloads)),
            substrate,
        )
        for i in range(count)
    )
    conditions = conditions_of(Plan(planned, timing), bench, values)
    rows = []
    for index, (run, seed) in enumerate(zip(planned, rng.integers(0, 2**31, count), strict=True)):
        settings = settings_of(run, timing, bench)
        zero = noise.zero_common + math.hypot(noise.zero_session, noise.zero_run) * rng.standard_normal()

        def record(with_noise: BenchNoise, offset: float, index: int = index, seed: int = seed) -> Recording:
            own = np.random.default_rng(seed)
            return record_run(model, conditions, index, values, settings, timing, offset, with_noise, own)  # noqa: B023

        found = extract(record(noise, zero), bench)
        clean = record(clean_noise(noise), 0.0)
        on, off = _edges(timing, run, settings.speed, np.random.default_rng(seed))
        truth = truth_of(clean, on, off, on + timing.travel / settings.speed, noise.white)
        if "no_zero" in found["flags"]:
            truth |= {name: truth[name] + zero for name in ABSOLUTE}
        rows += [
            (settings.run, name, truth[name], found[name], found[f"{name}_sd"])
            for name in OBSERVABLES
            if name in truth
        ]
    return pd.DataFrame(rows, columns=["run", "observable", "truth", "value", "sd"])


def summary(compared: pd.DataFrame) -> dict[str, dict[str, float]]:
    """By observable: runs, unusable, bias and scatter of (value - truth) / sd, cover of the 68 and 95 % intervals."""
    out = {}
    for name, part in compared.groupby("observable", sort=False):
        usable = part.dropna()
        pulls = ((usable["value"] - usable["truth"]) / usable["sd"]).to_numpy()
        out[str(name)] = {
            "runs": len(usable),
            "unusable": len(part) - len(usable),
            "mean_pull": float(pulls.mean()),
            "sd_pull": float(pulls.std()),
            "cover_68": float(np.mean(np.abs(pulls) < 0.99446)),
            "cover_95": float(np.mean(np.abs(pulls) < 1.95996)),
            "median_sd": float(usable["sd"].median()),
            "bias": float((usable["value"] - usable["truth"]).mean()),
        }
    return out


def _edges(
    timing: RecordTiming, run: PlannedRun, speed: float, own: np.random.Generator
) -> tuple[float, float]:
    """When the simulated voltage really came and went [s]: the same draws as in ``record_run``."""
    clock(timing.before + timing.travel / speed + timing.after, timing.sample_interval, own)
    on = timing.before + own.uniform(0.0, timing.sample_interval)
    return on, on + timing.travel / speed + half_wave(run.frequency)
