"""How far the gap closes, on conditions that the fit did not see, and what the parameters had absorbed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from eaclutch.diagnosis.cells import Cells
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.study import Study
from eaclutch.records import FloatArray

BOOTSTRAPS = 1000


def gap_numbers(cells: Cells, base: CandidateResult, after: CandidateResult, simulated: FloatArray,
                rng: np.random.Generator) -> dict[str, Any]:  # fmt: skip
    """Contract's ``closure``: before, after, floor, shrinkage and its 90 % interval.

    ``simulated`` (campaigns,): the statistic of campaigns without a gap; their median is the floor. What is closed and
    what is left are resampled over conditions (their cells move together), at least as widely as the simulated ones
    scatter. The interval is of closed / (closed + left), which ends at 1 unless something is left beyond that noise,
    and of anything in 0..1 to the extent that noise alone makes as large a gap before, or where a single condition says
    nothing of others. One that does not exceed the floor has nothing to close: shrinkage 0, interval 0..1.
    """
    floor = float(np.median(simulated))
    before_cells = _ratios(cells, base)
    after_cells = _ratios(cells, after)
    before, later = float(before_cells.mean()), float(after_cells.mean())
    if before <= floor:
        return {"before": before, "after": later, "noise_floor": floor, "shrinkage": 0.0,
                "interval": [0.0, 1.0], "held_out_by": "condition"}  # fmt: skip
    counts, index = _condition_draws(cells, rng)
    size = counts @ np.bincount(index)
    closed = (counts @ np.bincount(index, weights=before_cells - after_cells)) / size
    left = (counts @ np.bincount(index, weights=after_cells)) / size - floor
    low, high = np.quantile(simulated, [0.16, 0.84])
    # sessions scatter together, which conditions drawn anew do not show
    missing = max((0.5 * float(high - low)) ** 2 - float(np.var(left)), 0.0)
    left = left + np.sqrt(missing) * rng.standard_normal(BOOTSTRAPS)
    real = rng.choice(simulated, BOOTSTRAPS) < before
    shrinkage = (before - later) / (before - floor)
    least = _share(closed, np.maximum(left, 0.0), real, 0.0)
    most = np.minimum(_share(closed, left, real, 1.0), max(1.0, shrinkage))
    bottom, top = np.quantile(least, 0.05), np.quantile(most, 0.95)
    if counts.shape[1] < 2:
        bottom, top = 0.0, 1.0
    return {
        "before": before, "after": later, "noise_floor": floor, "shrinkage": float(shrinkage),
        "interval": [float(min(bottom, shrinkage)), float(max(top, shrinkage))], "held_out_by": "condition",
    }  # fmt: skip


def _share(closed: FloatArray, left: FloatArray, real: np.ndarray, otherwise: float) -> FloatArray:
    """closed / (closed + left), 1 where less than nothing is left, 0 where the gap widened by more than there was, and
    ``otherwise`` where it is not real."""
    whole = closed + left
    share = np.divide(closed, whole, out=np.where(left <= 0, 1.0, 0.0), where=whole > 0)
    return np.where(real, share, otherwise)


def surely_left(study: Study, results: Sequence[CandidateResult]) -> dict[tuple[str, ...], float]:
    """Of each set of effects, how many times the base model's gap on conditions left out it leaves in 95 % of their
    draws at least; 0 where a single condition says nothing of others."""
    draws = _condition_draws(study.cells, study.generator(16))
    every = np.arange(len(study.cells.variance))
    base = _ratios(study.cells, next(r for r in results if not r.effects))
    return {r.effects: _surely(draws, base, _ratios(study.cells, r), every) for r in results}


def widened(study: Study, results: Sequence[CandidateResult], best: tuple[str, ...]) -> list[str]:
    """A caveat where the most probable set ``best``, if it is a named one, surely predicts an observable worse than the
    base model does on conditions left out: what it closes elsewhere it does not close there."""
    after = next((_ratios(study.cells, r) for r in results if r.effects and r.effects == best), None)
    if after is None:
        return []
    draws = _condition_draws(study.cells, study.generator(16))
    base = _ratios(study.cells, next(r for r in results if not r.effects))
    said = []
    for name in dict.fromkeys(study.cells.observable):
        rows = np.flatnonzero(study.cells.observable == name)
        if _surely(draws, base, after, rows) > study.thresholds["caveats"]["wider"]:
            gaps = f"{base[rows].mean():.2g} to {after[rows].mean():.2g}"
            said.append(f"{name} (mean square over its repeats' variance {gaps})")
    return [f"predicted worse than without, conditions left out: {', '.join(said)}"] if said else []


def _surely(
    draws: tuple[FloatArray, np.ndarray], base: FloatArray, after: FloatArray, rows: np.ndarray
) -> float:
    """How many times the gap ``base`` (cells,) in the cells ``rows`` that of ``after`` is, in 95 % of ``draws`` of
    conditions at least; 0 where a single condition says nothing of others."""
    counts, index = draws
    if len(np.unique(index[rows])) < 2:
        return 0.0
    before, later = (
        counts @ np.bincount(index[rows], weights=ratios[rows], minlength=counts.shape[1])
        for ratios in (base, after)
    )
    return float(np.quantile(later / np.maximum(before, 1e-300), 0.05))


def total_gap(cells: Cells, base: CandidateResult, after: CandidateResult, simulated: FloatArray,
              rng: np.random.Generator) -> dict[str, Any]:  # fmt: skip
    """Contract's ``gap.total``; the interval is of ``before``, over conditions; ``simulated`` as in ``gap_numbers``."""
    ratio = _ratios(cells, base)
    counts, index = _condition_draws(cells, rng)
    draws = (counts @ np.bincount(index, weights=ratio)) / (counts @ np.bincount(index))
    value = float(ratio.mean())
    return {"before": value, "after": float(_ratios(cells, after).mean()),
            "noise_floor": float(np.median(simulated)), "interval": _interval(value, draws, simulated)}  # fmt: skip


def _interval(value: float, draws: FloatArray, simulated: FloatArray) -> list[float]:
    """90 % interval of a size by its ``draws`` over conditions. Where all of them agree (a single condition, which says
    nothing of others; none above its noise) by what noise alone moves it (``simulated`` sizes without a gap)."""
    if np.ptp(draws) == 0.0:
        draws = np.maximum(value + simulated - np.median(simulated), 0.0)
    low, high = np.quantile(draws, [0.05, 0.95])
    return [float(min(low, value)), float(max(high, value))]


def by_observable(cells: Cells, base: CandidateResult, after: CandidateResult, simulated: FloatArray,
                  p_values: Mapping[str, float], units: Mapping[str, str],
                  rng: np.random.Generator) -> dict[str, Any]:  # fmt: skip
    """Contract's ``gap.by_observable``: root of max(0, mean square - variance of the cells' means), in the observable's
    unit. ``noise_floor`` is the same number's median over campaigns without a gap, so ``before`` may lie below it."""
    before, later = (cells.errors(np.array(r.errors_left_out)[: len(cells.level)]) for r in (base, after))
    null = cells.errors(simulated[:, : len(cells.level)])
    found = {}
    for name in dict.fromkeys(cells.observable):
        rows = np.flatnonzero(cells.observable == name)
        variance = float(np.mean(cells.variance[rows]))

        def size(errors: FloatArray, variance: float = variance) -> Any:
            return np.sqrt(np.maximum(0.0, np.mean(errors**2, axis=-1) - variance))

        draws = size(before[rows[rng.integers(0, len(rows), (BOOTSTRAPS, len(rows)))]])
        value, noise = float(size(before[rows])), size(null[:, rows])
        found[name] = {
            "before": value, "after": float(size(later[rows])),
            "noise_floor": float(np.median(noise)),
            "interval": _interval(value, draws, noise),
            "unit": units[name], "p_value": float(p_values.get(name, 1.0)),
        }  # fmt: skip
    return found


def absorbed(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Any]:
    """How far each calibrated parameter, {name: {mean, sd, unit}}, moved back when the verdict's effects were added."""
    found = {}
    for name, entry in before.items():
        later = after.get(name)
        if later is None:
            continue
        sd = max(float(entry["sd"]), 1e-300)
        found[name] = {
            "before": entry["mean"], "after": later["mean"], "unit": entry["unit"],
            "shift_posterior_sd": (entry["mean"] - later["mean"]) / sd,
        }  # fmt: skip
    return found


def _ratios(cells: Cells, result: CandidateResult) -> FloatArray:
    errors = cells.errors(np.array(result.errors_left_out)[: len(cells.level)])
    return errors**2 / cells.variance


def _condition_draws(cells: Cells, rng: np.random.Generator) -> tuple[FloatArray, np.ndarray]:
    _, index = np.unique(cells.condition.astype(str), return_inverse=True)
    size = int(index.max()) + 1
    return rng.multinomial(size, np.full(size, 1 / size), size=BOOTSTRAPS).astype(float), index
