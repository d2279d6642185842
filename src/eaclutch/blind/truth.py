"""What is true of a case beyond the names: how far it lies from the base model, where, and each effect's share."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from eaclutch.blind.case import Case
from eaclutch.blind.frame import frame_of, own_constants, scaled_features
from eaclutch.blind.skeleton import FEATURES
from eaclutch.records import FloatArray


def truth_of(case: Case) -> dict[str, Any]:
    """Distances raw and after calibration, closure of every effect and pair, and where the gap lies."""
    names = tuple(name for name, _ in case.entry.effects)
    if not names and case.entry.misfit == 0.0:
        return {"distance": 0.0, "distance_calibrated": 0.0, "closure": {}, "where": []}
    plain = own_constants(case)
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
