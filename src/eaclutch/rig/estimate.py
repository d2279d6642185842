"""A measured number with its standard uncertainty, or the reason why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass


class Unusable(Exception):
    """The observable cannot be had from this run; the message is the reason, a stable word for a flag."""


@dataclass(frozen=True)
class Estimate:
    """``value`` +- ``sd`` (standard uncertainty, same unit); both NaN where ``reason`` says why.

    sd_zero_known: the standard uncertainty that would be left if the load cell's zero were known, where it is less.
    flag: a stable word for what happened in the run where the number is as defined and yet not what it is meant for.
    """

    value: float
    sd: float
    reason: str = ""
    sd_zero_known: float | None = None
    flag: str = ""

    @property
    def usable(self) -> bool:
        """Whether there is a number."""
        return math.isfinite(self.value) and math.isfinite(self.sd)

    @classmethod
    def missing(cls, reason: str) -> Estimate:
        """No number, and why."""
        return cls(math.nan, math.nan, reason)
