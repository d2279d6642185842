"""The nameless law: one quantity of the model that is not the same everywhere, but changes smoothly with one setting.

What a library lacks is most often not a new curve for one observable: it is a friction that falls from run to run, a
force that gives way at high frequency, a film that is thinner in the later sessions. Every observable then moves as
the model says for that quantity, which a smooth term for each block by itself cannot know. The change is a Gaussian
process over the setting; around a fit it adds (j j') * k(x, x') to the covariance, j being the derivative of the
predictions with respect to the logarithm of the quantity. Voltage and preload are not among the settings: most of what
the library names acts through the field, and the force multiplier's own slope is free to follow it; and what changes
with preload is edge wrap's to explain, or the smooth terms'.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, solve_triangular
from scipy.special import logsumexp

from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.gaussian import Linearised, log_normal
from eaclutch.diagnosis.mode import Mode
from eaclutch.diagnosis.readings import of_the_reading
from eaclutch.records import FloatArray

TOGETHER = {"friction": ("film_static", "film_kinetic"), "base_friction": ("base_static", "base_kinetic")}
SETTINGS = ("drive frequency", "voltage", "width", "preload", "run order")  # columns of ``run_features``
NAMED = ("voltage", "preload")  # settings through which what the library names acts
KNOTS = 8  # a smooth change over a setting needs no more
SMALL = 1e-3  # largest move of an entry, below which a quantity says nothing here


@dataclass(frozen=True)
class Modulated:
    """log_evidence (nats): over all quantities, settings and sizes; quantity, setting, size (sd of the logarithm): of
    the most probable one, whose fit is ``linearised``; discrepancy (entries,): what it does, as the data put it."""

    log_evidence: float
    quantity: str
    setting: str
    size: float
    linearised: Linearised
    discrepancy: FloatArray


def modulated_fit(
    base: Linearised, mode: Mode, data: DataVector, thresholds: Mapping[str, Any]
) -> Modulated | None:
    """Evidence of a nameless law around a fit's linearisation at ``mode``; None where nothing varies."""
    sizes = np.array(thresholds["modulated"]["sizes"], dtype=float)
    root = cho_factor(base.marginal(), lower=True)[0]
    white = solve_triangular(root, base.w, lower=True)
    found = [
        (gain, quantity, setting, size, columns)
        for quantity, setting, columns in changes(mode, data, thresholds)
        for gain, size in zip(
            gains(solve_triangular(root, columns, lower=True), white[:, None], sizes)[:, 0],
            sizes.tolist(),
            strict=True,
        )
    ]
    if not found:
        return None
    _, quantity, setting, size, columns = max(found, key=lambda f: f[0])
    change = size**2 * columns @ columns.T
    linearised = Linearised(base.w, base.jacobian, base.covariance + change)
    evidence = float(logsumexp([f[0] for f in found]) - np.log(len(found)))
    discrepancy = change @ np.linalg.solve(linearised.marginal(), base.w)
    return Modulated(
        evidence + log_normal(base.w, base.marginal()), quantity, setting, size, linearised, discrepancy
    )


def changes(
    mode: Mode, data: DataVector, thresholds: Mapping[str, Any]
) -> Iterator[tuple[str, str, FloatArray]]:
    """(quantity, setting, root of the covariance (entries, knots) where the quantity's logarithm changes by 1 sd)."""
    shapes = dict(_shapes(data, thresholds))
    for quantity, j in _quantities(mode, data):
        for setting, shape in shapes.items():
            yield quantity, setting, j[:, None] * shape


def gains(moved: FloatArray, white: FloatArray, sizes: FloatArray) -> FloatArray:
    """Nats (sizes, sets) by which a change explains data sets better than none does. ``moved`` (entries, knots): the
    change, ``white`` (entries, sets): the data, both whitened."""
    values, vectors = np.linalg.eigh(moved.T @ moved)
    along = (vectors.T @ (moved.T @ white)) ** 2
    return np.stack(
        [
            0.5 * np.sum(along / (s**-2 + values)[:, None], axis=0) - 0.5 * np.sum(np.log1p(s**2 * values))
            for s in sizes
        ]
    )


def _quantities(mode: Mode, data: DataVector) -> Iterator[tuple[str, FloatArray]]:
    """Derivatives (entries,) of the runs' predictions with respect to the logarithm of each positive quantity."""
    step = 1e-4
    ends = mode.priors.from_normal(mode.u + step * np.array([[-1.0], [1.0]]))
    steepness = (ends[1] - ends[0]) / (2 * step * np.where(mode.theta > 0, mode.theta, np.nan))
    runs = data.family == "run"
    by_name = {
        name: np.where(runs, mode.jacobian[:, i] / steepness[i], 0.0)
        for i, name in enumerate(mode.names)
        if "." not in name and not of_the_reading(name) and np.isfinite(steepness[i]) and steepness[i] > 0
    }
    for name, parts in TOGETHER.items():
        if all(part in by_name for part in parts):
            by_name[name] = sum((by_name[part] for part in parts), np.zeros(len(runs)))
    yield from ((name, j) for name, j in by_name.items() if np.max(np.abs(j)) > SMALL)


def _shapes(data: DataVector, thresholds: Mapping[str, Any]) -> Iterator[tuple[str, FloatArray]]:
    """Roots (entries, knots) of the correlation over each setting that varies, without their mean: a quantity that is
    off everywhere alike is a calibrated parameter, not a law."""
    scales, runs, n = thresholds["length_scales"], data.conditions, data.run_entries
    when = np.lexsort((runs.run_order, np.asarray(runs.session_number)))
    age = np.empty(len(when))
    age[when] = np.arange(len(when)) / max(1, len(when) - 1)

    def of_entries(values: FloatArray) -> FloatArray:
        return np.array([values[data.groups == group].mean() for group in data.entry_group])

    settings = {name: x for name, x in zip(SETTINGS, data.features[:n].T, strict=False) if name not in NAMED}
    settings["thickness"] = of_entries(np.log(runs.thickness) / scales["log_width"])
    settings["time in the campaign"] = of_entries(age / scales["order"])
    for name, x in settings.items():
        if np.ptp(x) < 1e-6:
            continue
        knots = np.unique(np.quantile(x, np.linspace(0, 1, KNOTS)))
        between = np.exp(-0.5 * (knots[:, None] - knots) ** 2) + 1e-9 * np.eye(len(knots))
        shape = np.exp(-0.5 * (x[:, None] - knots) ** 2) @ np.linalg.inv(np.linalg.cholesky(between)).T
        whole = np.zeros((len(data), len(knots)))
        whole[:n] = shape - shape.mean(axis=0)
        yield name, whole
