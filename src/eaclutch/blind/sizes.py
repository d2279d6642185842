"""The benchmark's sizes: how many cases of which kind, how many through raw logs, how many to a job."""

from __future__ import annotations

from dataclasses import dataclass

from eaclutch.records import InputError


@dataclass(frozen=True)
class Size:
    """``singles``: cases with one named effect, spread evenly over the sixteen; ``raw``: written as logs."""

    none: int
    unknown: int
    singles: int
    pairs: int
    raw: int
    batch: int

    @property
    def cases(self) -> int:
        return self.none + self.unknown + self.singles + self.pairs

    @property
    def batches(self) -> int:
        return -(-self.cases // self.batch)


SIZES = {
    "blind_small": Size(none=3, unknown=3, singles=5, pairs=1, raw=2, batch=6),
    "blind": Size(none=36, unknown=26, singles=48, pairs=10, raw=4, batch=10),
    "blind_long": Size(none=150, unknown=60, singles=96, pairs=30, raw=8, batch=8),
}


def size_of(name: str) -> Size:
    """The size of that name. Raises InputError where there is none."""
    if name not in SIZES:
        raise InputError(f"size {name}", "is none of the benchmark's", f"take one of {', '.join(SIZES)}")
    return SIZES[name]
