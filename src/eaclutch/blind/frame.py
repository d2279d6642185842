"""The base model around a case: what calibration, inexact laws and sessions may do to its features.

Distances are in standard deviations of the campaign's own noise. The base model's constants may move within
their priors first, as they do in any calibration; what is left is what a diagnosis could explain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from eaclutch.blind.bench_readings import capacitance_curve
from eaclutch.blind.candidates import NAMED
from eaclutch.blind.case import Case, clean_state
from eaclutch.blind.plan import generator
from eaclutch.blind.skeleton import FEATURES, FilmPath, film_path, skeleton
from eaclutch.blind.strangers import UNNAMED
from eaclutch.blind.world import Constants, draw_constants
from eaclutch.records import FloatArray

BENCH_SD = 0.006  # relative, of one level of the capacitance curve
BENCH_LEVELS = np.array([0.1, 0.3, 0.6, 1.0, 2.0, 4.0])  # N
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
    "stray_capacitance": (5e-13, False),
}
# What the film's motion does not depend on.
BEHIND_THE_FILM = {
    "stray_capacitance",
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
    plain = own_constants(case)
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


def own_constants(case: Case) -> Constants:
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
