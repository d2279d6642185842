"""What is true of a case beyond the names: how far it lies from the base model, where, and each effect's share.

Distances are in standard deviations of the campaign's own noise. The base model's constants may move within
their priors first, as they do in any calibration; what is left is what a diagnosis could explain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from eaclutch.blind.bench_readings import capacitance_curve
from eaclutch.blind.candidates import NAMED
from eaclutch.blind.case import Case, clean_state
from eaclutch.blind.clutch import Rest, at_rest
from eaclutch.blind.contact import contact_force
from eaclutch.blind.film import release_motion
from eaclutch.blind.loadtrain import (
    SWING_STEP,
    friction_forces,
    strengthened,
    swing,
    train_stiffness,
    weakened,
)
from eaclutch.blind.plan import generator
from eaclutch.blind.strangers import UNNAMED
from eaclutch.blind.world import Constants, Runs, draw_constants
from eaclutch.records import FloatArray

# Feature: (phase, absolute sd, relative sd) of one run.
FEATURES = {
    "engagement_time_s": ("engage", 6e-4, 0.0),
    "ramp_rate_n_s": ("ramp", 0.2, 0.01),
    "shear_capacity_n": ("ramp", 4e-3, 0.04),
    "slip_fraction": ("hold", 0.04, 0.0),
    "hold_creep_n_s": ("hold", 4e-3, 0.0),
    "release_time_10_s": ("release", 5e-5, 0.05),
    "release_time_50_s": ("release", 3.5e-5, 0.05),
    "release_time_90_s": ("release", 4e-5, 0.05),
    "final_force_n": ("after", 0.04, 0.0),
}
BENCH_SD = 0.006  # relative, of one level of the capacitance curve
BENCH_LEVELS = np.array([0.1, 0.3, 0.6, 1.0, 2.0, 4.0])  # N
STEPS = 1600  # of the swing: 6.4 ms
# Prior sd of the constants that a calibration moves; relative where True.
MOVABLE = {
    "contact_stiffness": (0.5, True),
    "roughness_sd": (0.08, True),
    "kappa_static": (1.5, False),
    "film_thickness": (1e-6, False),
    "stiffness": (500.0, False),
    "mass": (5e-5, False),
    "damping": (0.05, False),
    "base_static": (0.034, False),
    "base_kinetic": (0.008, False),
    "film_static": (0.010, False),
    "film_kinetic": (0.008, False),
}
BEHIND_THE_FILM = {
    "stiffness",
    "mass",
    "damping",
    "base_static",
    "base_kinetic",
    "film_static",
    "film_kinetic",
}
MULTIPLIER_SD = (0.3, 0.15)  # of a factor on the pull, and of its slope against V / 300 V
# No law is exact: each feature may be off by this share, smoothly in each factor, and from session to session.
TOLERANCE, SESSION_SPREAD = 0.03, 0.02


@dataclass(frozen=True)
class FilmPath:
    """What the film does, whatever rubs and swings behind it: at rest, and its contact force while released."""

    rest: Rest
    contact: FloatArray


def film_path(runs: Runs, c: Constants) -> FilmPath:
    """The film's part of ``skeleton``, the slow one."""
    rest = at_rest(runs, c)
    return FilmPath(
        rest, np.stack([contact_force(gap, runs, c) for gap in release_motion(rest.gap_on, runs, c)])
    )


def skeleton(runs: Runs, c: Constants, film: FilmPath | None = None) -> FloatArray:
    """Noise-free features (runs, features) without the chance of stick-slip: released from 85 % of capacity."""
    film = film_path(runs, c) if film is None else film
    off, on = (contact_force(gap, runs, c) for gap in (film.rest.gap_off, film.rest.gap_on))
    friction = friction_forces(on, off, runs, c)
    hold = friction.static_driven * strengthened(np.full(len(runs), 0.02), runs)
    stiffness, mass = train_stiffness(runs, c), c.mass + runs.knob("moving_mass")
    speed = np.maximum(hold - friction.kinetic_driven, 0) / np.sqrt(stiffness * mass)
    slide = friction.kinetic_driven * weakened(speed, runs)
    zeta = (c.damping + runs.knob("side_damping")) / (2 * np.sqrt(stiffness * mass))
    low = slide - np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)) * (hold - slide)
    gain, drift = runs.knob("reading_gain", 1.0), runs.knob("zero_drift")
    start = 0.85 * hold
    force = swing(film.contact, start, runs, c, STEPS)
    lag = runs.knob("readout_time")
    clock = SWING_STEP * np.arange(STEPS)
    final = force[-400:].mean(axis=0)
    times = []
    for share in (0.1, 0.5, 0.9):
        below = force < start + (final - start) * share
        first = np.argmax(below, axis=0)
        times.append(np.where(below.any(axis=0), clock[first] + lag, np.nan))
    columns = {
        "engagement_time_s": film.rest.onset,
        "ramp_rate_n_s": stiffness * c.stage_speed * runs.knob("speed_factor", 1.0) * gain,
        "shear_capacity_n": (hold - friction.kinetic_before) * gain,
        "slip_fraction": np.clip((hold - np.maximum(low, 0)) / hold, 0, 1),
        "hold_creep_n_s": drift,
        "release_time_10_s": times[0],
        "release_time_50_s": times[1],
        "release_time_90_s": times[2],
        "final_force_n": final * gain + drift * runs.drive_time,
    }
    return np.stack([columns[name] for name in FEATURES], axis=1)


def scaled_features(
    case: Case,
    effects: tuple[str, ...],
    c: Constants,
    pull: FloatArray | None = None,
    film: FilmPath | None = None,
) -> FloatArray:
    """Features and the capacitance curve in units of noise, flat, for a case that keeps only ``effects``.

    ``film``: the film's part, where it is known already.
    """
    runs = clean_state(case.design, c, generator(case.entry.namespace, case.entry.seed, "scatter"))
    if pull is not None:
        runs = runs.turn(force_factor=runs.knob("force_factor", 1.0) * pull)
    for name, size in case.entry.effects:
        if name in effects:
            stream = generator(case.entry.namespace, case.entry.seed, f"effect {name}")
            runs, c = (NAMED | UNNAMED)[name](runs, c, size, stream)
    features = skeleton(runs, c, film)  # a run without release has no release times: NaN
    curve = np.log(np.concatenate([capacitance_curve(c, BENCH_LEVELS, w) for w in (2e-3, 2.5e-3, 3e-3)]))
    return np.concatenate([features.ravel(), curve / BENCH_SD])


@dataclass(frozen=True)
class Frame:
    """The base model around a case: noise-free features, their noise, and the directions that explain nothing.

    base, scale (entries,); tangent (entries, directions): first a calibration's ``constants``, then what the laws
    may be off by, each in units of its prior.
    """

    base: FloatArray
    scale: FloatArray
    tangent: FloatArray
    constants: int

    def shift(self, moved: FloatArray) -> FloatArray:
        """From the base, in units of noise; entries that either side does not have (NaN) count nowhere."""
        return np.nan_to_num((moved - self.base) / self.scale)

    def left(self, shift: FloatArray) -> FloatArray:
        """What a calibration leaves of a shift: the constants have moved within their (unit) priors."""
        moving = self.tangent[:, : self.constants]
        return shift - moving @ np.linalg.solve(moving.T @ moving + np.eye(self.constants), moving.T @ shift)

    def distance(self, shift: FloatArray) -> float:
        """Of a shift from everything that constants, inexact laws and sessions may do [standard deviations]."""
        inner = np.eye(self.tangent.shape[1]) + self.tangent.T @ self.tangent
        moved = np.linalg.solve(inner, self.tangent.T @ shift)
        return float(np.sqrt(max(shift @ (shift - self.tangent @ moved), 0.0)))


def frame_of(case: Case) -> Frame:
    """The frame of a case, whatever effects it has."""
    plain = _own_constants(case)
    base = scaled_features(case, (), plain)  # NaN where a run does not release
    count = len(case.runs) * len(FEATURES)
    table = np.nan_to_num(base[:count].reshape(len(case.runs), len(FEATURES)))
    sd = np.stack([np.hypot(a, r * np.abs(table[:, j])) for j, (_, a, r) in enumerate(FEATURES.values())], 1)
    scale = np.concatenate([sd.ravel(), np.ones(len(base) - count)])
    directions = [np.nan_to_num((moved - base) / scale) for moved in _moved(case, plain, base)]
    constants = len(directions)
    rest = np.zeros(len(base) - count)
    for j in range(len(FEATURES)):
        for pattern in _patterns(case):
            column = np.zeros_like(table)
            column[:, j] = pattern * table[:, j] / sd[:, j]
            directions.append(np.concatenate([column.ravel(), rest]))
    return Frame(base, scale, np.stack(directions, axis=1), constants)


def _own_constants(case: Case) -> Constants:
    """The bench's constants before any effect."""
    return draw_constants(generator(case.entry.namespace, case.entry.seed, "constants"))


def _patterns(case: Case) -> list[FloatArray]:
    """Smooth shapes over the campaign (runs,), each of the size that a law may be off by."""
    d = case.design
    shapes = [np.ones(len(d.voltage))]
    for factor in (d.voltage, np.log(d.frequency), np.log(d.width), d.preload_target):
        shapes.append((factor - factor.mean()) / factor.std())
    found = [TOLERANCE * shape for shape in shapes]
    return found + [SESSION_SPREAD * (d.session == session) for session in np.unique(d.session)]


def truth_of(case: Case) -> dict[str, Any]:
    """Distances raw and after calibration, closure of every effect and pair, and where the gap lies."""
    names = tuple(name for name, _ in case.entry.effects)
    if not names and case.entry.misfit == 0.0:
        return {"distance": 0.0, "distance_calibrated": 0.0, "closure": {}, "where": []}
    plain = _own_constants(case)
    bent = replace(plain, law=case.entry.misfit_law, law_share=case.entry.misfit)
    frame = frame_of(case)
    shifts = {kept: frame.shift(scaled_features(case, kept, bent)) for kept in _subsets(names)}
    left = {kept: frame.left(shift) for kept, shift in shifts.items()}
    whole = left[names]
    closure = {}
    for kept in _subsets(names):
        rest = tuple(name for name in names if name not in kept)
        if kept and np.sum(whole**2) > 0:
            closure["+".join(sorted(kept))] = float(1 - np.sum(left[rest] ** 2) / np.sum(whole**2))
    return {
        "distance": float(np.linalg.norm(shifts[names])),
        "distance_calibrated": frame.distance(shifts[names]),
        "closure": closure,
        "where": places(whole, case),
    }


def _moved(case: Case, c: Constants, base: FloatArray) -> list[FloatArray]:
    """Features with each constant moved by its prior sd (a tenth of it, scaled up), then the two multipliers."""
    scatter = generator(case.entry.namespace, case.entry.seed, "scatter")
    film = film_path(clean_state(case.design, c, scatter), c)
    out = []
    for name, (sd, relative) in MOVABLE.items():
        step = 0.1 * sd * (getattr(c, name) if relative else 1.0)
        moved = replace(c, **{name: getattr(c, name) + step})
        out.append(scaled_features(case, (), moved, film=film if name in BEHIND_THE_FILM else None))
    v = case.design.voltage / 300
    for sd, shape in zip(MULTIPLIER_SD, (np.ones_like(v), v - v.mean()), strict=True):
        out.append(scaled_features(case, (), c, pull=1 + 0.1 * sd * shape))
    return [base + (moved - base) / 0.1 for moved in out]


def _subsets(names: tuple[str, ...]) -> list[tuple[str, ...]]:
    if len(names) == 2:
        return [(), (names[0],), (names[1],), names]
    return [(), names] if names else [()]


def places(left: FloatArray, case: Case) -> list[dict[str, Any]]:
    """Observables by their share of the gap that is left, each with its phase and the factors that order it.

    A factor's ``explained`` is the share of the squared residual that its level means carry; ``all`` is the
    overall mean's.
    """
    count = len(case.runs) * len(FEATURES)
    table = left[:count].reshape(len(case.runs), len(FEATURES))
    parts = {name: np.sum(table[:, j] ** 2) for j, name in enumerate(FEATURES)}
    parts["capacitance"] = np.sum(left[count:] ** 2)
    total = max(sum(parts.values()), 1e-12)
    out = []
    for name in sorted(parts, key=lambda n: -parts[n]):
        share = float(parts[name] / total)
        if share < 0.05:
            break
        row: dict[str, Any] = {"observable": name, "share": share}
        if name == "capacitance":
            row |= {"phase": "capacitance", "factors": {"all": 1.0}}
        else:
            column = table[:, list(FEATURES).index(name)]
            row |= {"phase": FEATURES[name][0], "factors": _factors(column, case)}
            row["direction"] = "+" if column.sum() > 0 else "-"
        out.append(row)
    return out


def _factors(column: FloatArray, case: Case) -> dict[str, float]:
    d = case.design
    levels = {
        "all": np.zeros(len(column)),
        "voltage_v": d.voltage,
        "frequency_hz": d.frequency,
        "width_mm": d.width,
        "preload_n": np.digitize(d.preload_target, (0.25, 0.75, 1.5)),
        "session": d.session,
        "run_order": np.digitize(d.order, (7, 14)),
    }
    energy = max(float(np.sum(column**2)), 1e-12)
    out = {}
    for name, level in levels.items():
        means = np.zeros_like(column)
        for value in np.unique(level):
            means[level == value] = column[level == value].mean()
        out[name] = float(np.sum(means**2) / energy)
    return out
