"""Where the gap lies: observable x factor x level, its share of what can be closed, and what it is confounded with.

All p-values come from campaigns simulated from the fit whose errors are looked at, adjusted for the whole table at
once. The table that is tested is larger than the one that is shown: every observable with every two-way split of
every factor, besides "all". Where an effect is named, its place is the split that says most of what calibration
leaves of the effect (a factor on the force takes up the rest), by the side where the effect does more; where none
fits, of the lookalike or the nameless smooth term that says best what would. Repeats and sessions scatter around that:
a place that noise alone would have shown has a large p-value. The bench's capacitance is one place more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.diagnosis.cells import Cells
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.gate import max_statistic
from eaclutch.diagnosis.gaussian import Linearised, posterior_mean
from eaclutch.diagnosis.placing import Entries
from eaclutch.diagnosis.splits import Split, confounded, settings_of, splits_of
from eaclutch.records import FloatArray

SHOWN = 12  # rows of the table


@dataclass(frozen=True)
class Explained:
    """What a verdict accounts for, each (entries,) on the comparison scale.

    shift: how far it moves the entries with every parameter held. left: what is left of that once the calibrated
    parameters have followed it as far as the repeats' noise and their priors let them. noise: the repeats' sd.
    """

    shift: FloatArray
    left: FloatArray
    noise: FloatArray

    @classmethod
    def of(cls, shift: FloatArray, jacobian: FloatArray, noise: FloatArray) -> Explained:
        """From a shift, the base model's ``jacobian`` (entries, parameters in prior sds) and the covariance of the
        repeats' ``noise`` (entries, entries)."""
        taken = posterior_mean(Linearised(shift, jacobian, noise))
        return cls(shift, shift - jacobian @ taken, np.sqrt(np.diag(noise)))

    def at(self, index: np.ndarray) -> Explained:
        """Of these entries."""
        return Explained(self.shift[index], self.left[index], self.noise[index])


@dataclass(frozen=True)
class Where:
    """The table, and the p-value of each observable on its own (same family)."""

    rows: list[dict[str, Any]]
    observable_p: Mapping[str, float]


@dataclass(frozen=True)
class _Places:
    """All places that are tested: (observable, split) of each, its weights ``masks`` (places, entries), what is looked
    for in them, ``excess`` (entries,), and the thresholds file's ``place``."""

    tests: Sequence[tuple[str, Split]]
    masks: FloatArray
    excess: FloatArray
    rules: Mapping[str, float]

    def of(self, name: str) -> tuple[list[int], int | None]:
        """Indices of an observable's places, and of that which is all of it; None where it has none."""
        mine = [i for i, (observable, _) in enumerate(self.tests) if observable == name]
        return mine, next((i for i in mine if self.tests[i][1].factor == "all"), None)


def localise(
    data: DataVector,
    cells: Cells,
    errors: FloatArray,
    simulated: FloatArray,
    rng: np.random.Generator,
    rules: Mapping[str, float],
    explained: Explained | None = None,
) -> Where:
    """Find the places.

    errors (entries,): measured less predicted by the base model, conditions left out; simulated
    (campaigns, entries): the same of campaigns simulated from it. explained: what of these errors the verdict
    accounts for, if there is a gap. Returns rows sorted by share.
    """
    entries, settings = Entries.of(data), settings_of(data)
    bench = len(entries.index) - entries.runs
    names = list(dict.fromkeys([*(channel.name for channel in data.channels), *entries.observable]))
    ratio, null = (entries.excess(data, cells, e) for e in (errors, simulated))
    splits = [
        (split, np.append(split.member, np.full(bench, float(split.factor == "all"))))
        for split in splits_of(data)
    ]
    tests = [(name, split) for name in names for split, _ in splits]
    masks = np.array([(entries.observable == name) * member for name in names for _, member in splits])
    use = masks.sum(axis=1) > 0
    tests, masks = [t for t, keep in zip(tests, use, strict=True) if keep], masks[use]
    size = masks.sum(axis=1)
    # a strip left out is predicted far worse than its readings repeat: counted in what is usual for that
    usual = np.where(np.arange(len(ratio)) < entries.runs, 1.0, null.mean(axis=0))
    p_values = max_statistic(
        np.log1p(masks @ (ratio / usual) / size), np.log1p((null / usual) @ masks.T / size)
    )
    observable_p = {
        name: float(p_values[i]) for i, (name, split) in enumerate(tests) if split.factor == "all"
    }
    excess, least = ratio - null.mean(axis=0), 0.0
    if explained is not None:
        least = rules["least_share"]
        excess, explained = entries.excess(data, cells, explained.shift), explained.at(entries.index)
    places, rows = _Places(tests, masks, excess, rules), []
    for name in names:
        found = (
            _place(name, places, p_values) if explained is None else _where_it_acts(name, places, explained)
        )
        if found is not None:
            split, index = found
            at, p_value = errors[entries.index], float(p_values[index])
            told_by = confounded(split, settings, rules["confounded"])
            rows.append(entries.row(data, name, split, told_by, masks[index], excess, at, p_value, rng))
    rows = sorted((row for row in rows if row["share"] >= least), key=lambda row: -row["share"])
    return Where(rows[:SHOWN], observable_p)


def _place(name: str, places: _Places, p_values: FloatArray) -> tuple[Split, int] | None:
    """The narrowest place that holds nearly all of an observable's excess, or None without a significant one."""
    (mine, every), rules = places.of(name), places.rules
    if every is None or min(p_values[i] for i in mine) > rules["level"]:
        return None
    masks, excess = places.masks, places.excess
    total, cells = float(masks[every] @ excess), float(masks[every].sum())
    best, best_score = every, 1.0
    for i in mine:
        share, part = float(masks[i] @ excess) / max(total, 1e-12), float(masks[i].sum()) / cells
        # concentration against what an even spread would put there; a place must hold most of the gap
        if p_values[i] <= rules["level"] and share >= rules["holds"] and part <= rules["nearly_all"]:
            score = share**2 / max(part, 0.05)
            if score > (rules["concentration"] if best == every else 1.05) * best_score:
                best, best_score = i, score
    if p_values[best] > rules["level"]:
        best = min(mine, key=lambda i: p_values[i])
    return places.tests[best][1], best


def _where_it_acts(name: str, places: _Places, explained: Explained) -> tuple[Split, int] | None:
    """Where what is known to act on an observable does, or None where it does nothing there.

    The excess is what it does, squared over the repeats' variance. The split whose two means say most of what
    calibration leaves of it (of all it does, where less than noise is left), by the side that holds more of the excess
    (of sessions: the one that does) unless that is nearly all there is; "all" where one mean says nearly as much, or
    the side holds little of it.
    """
    (mine, every), rules = places.of(name), places.rules
    masks, excess = places.masks, places.excess
    if every is None or not masks[every] @ excess > 0.0:
        return None
    felt = float(masks[every] @ (explained.left / explained.noise) ** 2)
    pattern = explained.left if felt > 1.0 else explained.shift
    size, total = float(masks[every].sum()), float(masks[every] @ pattern)
    said = {every: total**2 / size}
    for i in mine:
        inside, part = float(masks[i] @ pattern), float(masks[i].sum())
        if 0.0 < part < size:
            said[i] = inside**2 / part + (total - inside) ** 2 / (size - part)
    most = max(said.values())
    best = every
    if said[every] < rules["mean_says"] * most:
        sides = [i for i, value in said.items() if value >= (1.0 - 1e-9) * most]
        if any(places.tests[i][1].factor == "session" for i in sides):
            # the other side of one session is several: any of them
            sides = [i for i in mine if places.tests[i][1].factor == "session"]
        sides = [i for i in sides if masks[i].sum() <= rules["nearly_all"] * size] or sides
        side = max(sides, key=lambda i: float(masks[i] @ excess))
        if masks[side] @ excess >= rules["side_holds"] * float(masks[every] @ excess):
            best = side
    return places.tests[best][1], best
