"""Where the gap lies: observable x factor x level, its share of what can be closed, and what it is confounded with.

All p-values come from campaigns simulated from the fit whose errors are looked at, adjusted for the whole table at
once. The table that is tested is larger than the one that is shown: every observable with every two-way split of
every factor, besides "all". Where an effect is named, its place is the split that says most of what the effect does;
where none fits, of how the nameless smooth term departs from the base model. Repeats and sessions scatter around
that: a place that noise alone would have shown has a large p-value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.diagnosis.cells import Cells
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.gate import max_statistic
from eaclutch.diagnosis.splits import Split, confounded, settings_of, splits_of
from eaclutch.records import FloatArray

SHOWN = 12  # rows of the table
MOST = 0.7  # share of an observable's gap that its place must hold
NEARLY = 0.8  # of what the best split of a signature says, from which its overall mean says enough
MORE = 1.4  # how much more concentrated than an even spread a place must be, to be named instead of "all"
MOSTLY_ALL = 0.85  # a level that holds this share of the cells is no place of its own
LEAST = 0.05  # share of the gap from which a place that the named effect explains is shown


@dataclass(frozen=True)
class Where:
    """The table, and the p-value of each observable on its own (same family)."""

    rows: list[dict[str, Any]]
    observable_p: Mapping[str, float]


def localise(
    data: DataVector,
    cells: Cells,
    errors: FloatArray,
    simulated: FloatArray,
    rng: np.random.Generator,
    explained: FloatArray | None = None,
    *,
    level: float = 0.05,
) -> Where:
    """Find the places.

    errors (entries,): measured less predicted by the base model, conditions left out; simulated
    (campaigns, entries): the same of campaigns simulated from it. explained (entries,): what of these errors the
    verdict accounts for, if there is a gap. Returns rows sorted by share.
    """
    n = data.run_entries
    splits, settings = splits_of(data), settings_of(data)
    names = [channel.name for channel in data.channels]
    own = np.array([data.channel[:n] == name for name in names])
    ratio, null = _excess(data, cells, errors), _excess(data, cells, simulated)
    tests: list[tuple[str, Split]] = [(name, split) for name in names for split in splits]
    masks = np.array([own[names.index(name)] * split.member for name, split in tests])
    use = masks.sum(axis=1) > 0
    tests, masks = [t for t, keep in zip(tests, use, strict=True) if keep], masks[use]
    size = masks.sum(axis=1)
    p_values = max_statistic(np.log1p(masks @ ratio / size), np.log1p(null @ masks.T / size))
    observable_p = {
        name: float(p_values[i]) for i, (name, split) in enumerate(tests) if split.factor == "all"
    }
    excess, least, signature = ratio - null.mean(axis=0), 0.0, None
    if explained is not None:
        level, least = 1.0, LEAST
        excess = _excess(data, cells, explained)
        signature = explained[:n]
    rows = []
    for name in names:
        found = (
            _place(name, tests, masks, excess, p_values, level)
            if signature is None
            else _where_it_acts(name, tests, masks, signature)
        )
        if found is not None:
            test, index = found
            rows.append(
                _row(name, test, masks[index], excess, errors[:n], p_values[index], data, settings, rng)
            )
    rows = sorted((row for row in rows if row["share"] >= least), key=lambda row: -row["share"])
    return Where(rows[:SHOWN], observable_p)


def _excess(data: DataVector, cells: Cells, errors: FloatArray) -> FloatArray:
    """Squared entry errors (..., entries) over the variance of the entry's mean, weighted like the contract's
    cells."""
    n = data.run_entries
    gather = cells.gather.tocsc()
    cell = np.array([gather.indices[gather.indptr[i]] for i in range(n)])
    weight = np.asarray(gather.max(axis=0).todense()).ravel()
    variance = cells.variance[cell] / np.maximum(weight, 1e-12)
    found: FloatArray = weight * cells.native(errors[..., :n]) ** 2 / variance
    return found


def _place(
    name: str,
    tests: Sequence[tuple[str, Split]],
    masks: FloatArray,
    excess: FloatArray,
    p_values: FloatArray,
    level: float,
) -> tuple[Split, int] | None:
    """The narrowest place that holds nearly all of an observable's excess, or None without a significant one."""
    mine = [i for i, (observable, _) in enumerate(tests) if observable == name]
    if not mine or min(p_values[i] for i in mine) > level:
        return None
    every = next(i for i in mine if tests[i][1].factor == "all")
    total, cells = float(masks[every] @ excess), float(masks[every].sum())
    best, best_score = every, 1.0
    for i in mine:
        share, part = float(masks[i] @ excess) / max(total, 1e-12), float(masks[i].sum()) / cells
        # concentration against what an even spread would put there; a place must hold most of the gap
        if p_values[i] <= level and share >= MOST and part <= MOSTLY_ALL:
            score = share**2 / max(part, 0.05)
            if score > (MORE if best == every else 1.05) * best_score:
                best, best_score = i, score
    if p_values[best] > level:
        best = min(mine, key=lambda i: p_values[i])
    return tests[best][1], best


def _where_it_acts(
    name: str, tests: Sequence[tuple[str, Split]], masks: FloatArray, signature: FloatArray
) -> tuple[Split, int] | None:
    """Where what is known to act on an observable does, or None where it does nothing there.

    signature (entries,): its shift on the comparison scale. The split whose two means say most of it, by the side
    that holds more; "all" where one mean says nearly as much.
    """
    mine = [i for i, (observable, _) in enumerate(tests) if observable == name]
    every = next((i for i in mine if tests[i][1].factor == "all"), None)
    if every is None or not masks[every] @ signature**2 > 0.0:
        return None
    size, total = float(masks[every].sum()), float(masks[every] @ signature)
    said = {every: total**2 / size}
    for i in mine:
        inside, part = float(masks[i] @ signature), float(masks[i].sum())
        if 0.0 < part < size:
            said[i] = inside**2 / part + (total - inside) ** 2 / (size - part)
    most = max(said.values())
    if said[every] >= NEARLY * most:
        return tests[every][1], every
    sides = [i for i, value in said.items() if value >= (1.0 - 1e-9) * most]
    best = max(sides, key=lambda i: float(masks[i] @ signature**2))
    return tests[best][1], best


def _row(
    name: str,
    split: Split,
    mask: FloatArray,
    excess: FloatArray,
    errors: FloatArray,
    p_value: float,
    data: DataVector,
    settings: Mapping[str, FloatArray],
    rng: np.random.Generator,
) -> dict[str, Any]:
    channel = next(c for c in data.channels if c.name == name)
    share, interval = _share(mask, excess, data, rng)
    mean = float(mask @ errors) / max(float(mask.sum()), 1e-12)
    return {
        "observable": name,
        "factor": split.factor,
        "level": split.level,
        "phase": channel.phase,
        "share": share,
        "interval": interval,
        "direction": "+" if mean >= 0 else "-",
        "p_value": float(p_value),
        "confounded_with": confounded(split, settings),
    }


def _share(
    mask: FloatArray, excess: FloatArray, data: DataVector, rng: np.random.Generator
) -> tuple[float, list[float]]:
    """Share of the closable gap in ``mask`` and its 90 % bootstrap interval over conditions."""
    conditions = np.array(data.condition[: len(mask)], dtype=str)
    _, index = np.unique(conditions, return_inverse=True)
    inside = np.bincount(index, weights=mask * excess)
    channels = np.array(data.channel[: len(mask)], dtype=str)
    # an observable below its floor has nothing to close, and takes nothing off the others
    totals = np.array([np.bincount(index, weights=(channels == c) * excess) for c in np.unique(channels)])
    counts = rng.multinomial(len(inside), np.full(len(inside), 1 / len(inside)), size=400)
    with np.errstate(divide="ignore", invalid="ignore"):
        draws = np.clip((counts @ inside) / np.maximum(totals @ counts.T, 0.0).sum(axis=0), 0.0, 1.0)
    draws = draws[np.isfinite(draws)]
    total = float(np.maximum(totals.sum(axis=1), 0.0).sum())
    share = float(np.clip(inside.sum() / total, 0.0, 1.0)) if total > 0 else 0.0
    if len(draws) == 0:
        return share, [0.0, 1.0]
    low, high = np.quantile(draws, [0.05, 0.95])
    return share, [min(float(low), share), max(float(high), share)]
