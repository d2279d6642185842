"""A forecast's detection limits, said in this generator's own sizes.

The forecast (the library's, frozen before) states how far a just detectable effect moves a campaign, in standard
deviations of its noise after calibration. Both sides know that distance, whatever their laws.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.blind.case import build_case
from eaclutch.blind.plan import SIZE_RANGE, Entry
from eaclutch.blind.truth import frame_of, scaled_features

GRID = np.geomspace(0.05, 6.0, 7)
DESIGNS = (1, 2)  # seeds of the campaigns on which distances are taken


def distance_by_size(name: str, grid: np.ndarray = GRID) -> np.ndarray:
    """Distance after calibration at each size of an effect, geometric mean over the designs, (sizes,)."""
    found = []
    for seed in DESIGNS:
        frame = frame_of(build_case(Entry("limits", "test", seed, "none", ())))
        rows = []
        for size in grid:
            case = build_case(Entry("limits", "test", seed, "single", ((name, float(size)),)))
            moved = scaled_features(case, (name,), case.constants)
            rows.append(frame.distance(frame.shift(moved)))
        found.append(rows)
    return np.exp(np.mean(np.log(np.maximum(found, 1e-6)), axis=0))


def sizes_at(distances: Mapping[str, float | None]) -> dict[str, float]:
    """Size of each effect at its distance; the largest sensible one where none reaches it or none is stated."""
    out = {}
    for name, target in distances.items():
        reached = np.maximum.accumulate(distance_by_size(name))
        if target is None or target > reached[-1]:
            out[name] = float(SIZE_RANGE[1] / 4)
        else:
            out[name] = float(np.exp(np.interp(np.log(target), np.log(reached), np.log(GRID))))
    return out
