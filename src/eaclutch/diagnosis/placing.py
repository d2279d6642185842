"""What places are made of: squared errors over the repeats' variance, and the row that says one place.

The bench's capacitance readings are an observable here, as the contract's phases have it, with a cell a load and strip
width: an effect that biases the gap is seen nowhere else. They lie outside the runs' factors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.diagnosis.cells import Cells
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.splits import Split
from eaclutch.records import FloatArray

CAPACITANCE = "capacitance_pf"
RESAMPLED = 400  # times


@dataclass(frozen=True)
class Entries:
    """The entries that have a place: those of runs, then the bench's capacitance. Each array (entries,).

    index: into the data vector; observable, condition: names (a capacitance's condition is its width); runs: how
    many of the first ones are of runs.
    """

    index: np.ndarray
    observable: np.ndarray
    condition: np.ndarray
    runs: int

    @classmethod
    def of(cls, data: DataVector) -> Entries:
        """Those of ``data``."""
        n = data.run_entries
        bench = n + np.flatnonzero(data.block[n:] == "capacitance")
        widths = [f"width {width:.6g}" for width in data.bench.width[bench - n]]
        return cls(
            np.concatenate([np.arange(n), bench]),
            np.concatenate([data.channel[:n].astype(str), np.full(len(bench), CAPACITANCE)]).astype(object),
            np.concatenate([data.condition[:n].astype(str), widths]).astype(object),
            n,
        )

    def of_widths(self) -> list[np.ndarray]:
        """The bench's capacitance by strip width: what is left out together, each into the data vector."""
        index, width = self.index[self.runs :], self.condition[self.runs :].astype(str)
        return [index[width == w] for w in dict.fromkeys(width)]

    def excess(self, data: DataVector, cells: Cells, errors: FloatArray) -> FloatArray:
        """Squared errors (..., entries) over the variance of the entry's mean, weighted like the contract's cells;
        ``errors`` (..., all entries of the data)."""
        n = self.runs
        gather = cells.gather.tocsc()
        cell = np.array([gather.indices[gather.indptr[i]] for i in range(n)])
        weight = np.asarray(gather.max(axis=0).todense()).ravel()
        variance = cells.variance[cell] / np.maximum(weight, 1e-12)
        bench = self.index[n:]
        noise = data.noise_sd[bench] ** 2 + data.offset_sd[bench] ** 2
        found: FloatArray = np.concatenate(
            [
                weight * cells.native(errors[..., :n]) ** 2 / variance,
                errors[..., bench] ** 2 / noise,
            ],
            axis=-1,
        )
        return found

    def row(
        self,
        data: DataVector,
        observable: str,
        split: Split,
        confounded: list[str],
        mask: FloatArray,
        excess: FloatArray,
        errors: FloatArray,
        p_value: float,
        rng: np.random.Generator,
    ) -> dict[str, Any]:
        """One row of the table (contract): the place that ``mask`` (entries,) weighs; ``errors``, ``excess``
        (entries,) say which way and how much of the gap."""
        share, interval = self._share(mask, excess, rng)
        mean = float(mask @ errors) / max(float(mask.sum()), 1e-12)
        return {
            "observable": observable,
            "factor": split.factor,
            "level": split.level,
            "phase": next((c.phase for c in data.channels if c.name == observable), "capacitance"),
            "share": share,
            "interval": interval,
            "direction": "+" if mean >= 0 else "-",
            "p_value": float(p_value),
            "confounded_with": confounded,
        }

    def _share(
        self, mask: FloatArray, excess: FloatArray, rng: np.random.Generator
    ) -> tuple[float, list[float]]:
        """Share of the closable gap in ``mask`` and its 90 % bootstrap interval over conditions."""
        _, index = np.unique(self.condition.astype(str), return_inverse=True)
        inside = np.bincount(index, weights=mask * excess)
        # an observable below its floor has nothing to close, and takes nothing off the others
        names = np.unique(self.observable.astype(str))
        totals = np.array([np.bincount(index, weights=(self.observable == c) * excess) for c in names])
        counts = rng.multinomial(len(inside), np.full(len(inside), 1 / len(inside)), size=RESAMPLED)
        with np.errstate(divide="ignore", invalid="ignore"):
            draws = (counts @ inside) / np.maximum(totals @ counts.T, 0.0).sum(axis=0)
        draws = np.clip(draws[np.isfinite(draws)], 0.0, 1.0)
        total = float(np.maximum(totals.sum(axis=1), 0.0).sum())
        share = float(np.clip(inside.sum() / total, 0.0, 1.0)) if total > 0 else 0.0
        if len(draws) == 0:
            return share, [0.0, 1.0]
        low, high = np.quantile(draws, [0.05, 0.95])
        return share, [min(float(low), share), max(float(high), share)]
