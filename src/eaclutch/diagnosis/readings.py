"""How a run's forces are read: zeros that it does not show, and peaks that are the largest of many.

Most runs begin in contact, so the force without contact is not in their log, and their friction before the
voltage, their force at switch-off and every ratio of forces still contain the session's zero (tens of mN): one
free offset a session, for the runs that still hold it.

The capacity is the largest force of a run, over many slips whose static friction scatters and over the noise
that smoothing leaves: more than the typical slip, by a share and by a few mN that are free as well. Where static
friction scatters by itself the largest slip falls deeper, too, for it overshoots the kinetic friction farther; where
both scatter together it lets go the same share. Which of the two it is nothing says beforehand, so how much of the
scatter is static friction's own is free.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from eaclutch.diagnosis.channels import Channel
from eaclutch.diagnosis.data import DataVector
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.physics.laws import larger_slip
from eaclutch.physics.model import ClutchModel
from eaclutch.records import FloatArray, RunConditions
from eaclutch.rig.zero import UNKNOWN_ZERO_SD

LARGEST_ZERO = 0.2  # N
PREFIX = "force_zero_"
PEAK_SHARE, PEAK_NOISE, PEAK_STATIC = (
    "largest_slip_excess",
    "largest_noise_excess",
    "largest_slip_static_share",
)
PEAKS = (
    Parameter(PEAK_SHARE, "1", (0.0, 0.3), 0.03, Prior("halfnormal", 0.05)),
    Parameter(PEAK_NOISE, "N", (0.0, 0.02), 0.003, Prior("halfnormal", 0.005)),
    Parameter(PEAK_STATIC, "1", (0.0, 1.0), 0.5, Prior("uniform", 0.0, 1.0)),
)
PEAK_NAMES = tuple(parameter.name for parameter in PEAKS)


def of_the_reading(name: str) -> bool:
    """Whether a parameter says how forces are read, and nothing of the clutch."""
    return name.startswith(PREFIX) or name in PEAK_NAMES


def of_the_readings(names: Sequence[str], u: FloatArray) -> dict[str, float]:
    """Of parameters ``u`` (params,) those of the reading, by name."""
    return {name: float(u[i]) for i, name in enumerate(names) if of_the_reading(name)}


@dataclass(frozen=True)
class Readings:
    """Sessions with an unknown zero, and which run holds which (runs,), -1 for none; ``peaks``: whether the
    largest force of a run is among the data."""

    sessions: tuple[str, ...]
    index: np.ndarray
    peaks: bool

    @classmethod
    def of(cls, data: DataVector) -> Readings:
        """What is unknown of a campaign's readings."""
        held = [s for s, unknown in zip(data.conditions.session, data.zero_unknown, strict=True) if unknown]
        sessions = tuple(dict.fromkeys(held))
        index = [
            sessions.index(s) if unknown else -1
            for s, unknown in zip(data.conditions.session, data.zero_unknown, strict=True)
        ]
        peaks = any(c.name in ("shear_capacity_n", "slip_fraction") for c in data.channels)
        return cls(sessions, np.array(index, dtype=int), peaks)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """One zero a session [N], and by how much peaks exceed the typical slip."""
        zeros = tuple(
            Parameter(
                f"{PREFIX}{s}", "N", (-LARGEST_ZERO, LARGEST_ZERO), 0.0, Prior("normal", 0.0, UNKNOWN_ZERO_SD)
            )
            for s in self.sessions
        )
        return zeros + (PEAKS if self.peaks else ())

    def select(self, rows: np.ndarray) -> Readings:
        """The same for some of the runs."""
        return replace(self, index=self.index[rows])

    def without(self, named: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Parameters by name, without those of the reading: what the model knows."""
        return {name: v for name, v in named.items() if not of_the_reading(name)}

    def predict(
        self,
        model: ClutchModel,
        conditions: RunConditions,
        named: Mapping[str, FloatArray],
        channels: Sequence[Channel],
    ) -> FloatArray:
        """Run-level predictions as the rig would read them, zeros included: (draws, channels, runs) on the
        comparison scale, not-a-number where the model's status says that there is none."""
        known = self.without(named)
        draws, runs = len(next(iter(known.values()))), len(conditions)
        zeros = np.zeros((draws, len(self.sessions) + 1))
        for i, session in enumerate(self.sessions):
            zeros[:, i] = named.get(f"{PREFIX}{session}", 0.0)
        # a zero is taken off measured forces, which are settings of a run: one row of runs for all draws
        held = zeros[:, self.index]
        true = replace(
            _tiled(conditions, draws),
            friction_before=(conditions.friction_before - held).ravel(),
            switch_off_force=(conditions.switch_off_force - held).ravel(),
        )
        flat = {name: np.repeat(value, runs)[None] for name, value in known.items()}
        peaks = np.array([np.broadcast_to(named.get(p.name, 0.0), draws) for p in PEAKS])
        found = self._predict(model, true, flat, channels, held.ravel(), np.repeat(peaks, runs, axis=1))
        return found.reshape(len(channels), draws, runs).transpose(1, 0, 2)

    def _predict(
        self,
        model: ClutchModel,
        true: RunConditions,
        named: Mapping[str, FloatArray],
        channels: Sequence[Channel],
        held: FloatArray,
        peaks: FloatArray,
    ) -> FloatArray:
        """(channels, simulations) of runs whose forces have lost their zeros ``held``."""
        names = [channel.name for channel in channels]
        wanted = names if "shear_capacity_n" in names else [*names, "shear_capacity_n"]
        found = model.predict(true, named, observables=wanted, on_invalid="status").values
        values = {name: value[0] for name, value in found.items()}
        share, noise, static_share = peaks
        typical = np.maximum(values["shear_capacity_n"] + true.friction_before, 1e-3)
        top = typical * (1.0 + share)
        values["shear_capacity_n"] = top + noise - true.friction_before
        if "slip_fraction" in names:
            # the extractor's slip is no larger for noise, but over a force that holds the zero
            typical_slip = values["slip_fraction"]
            deeper = larger_slip(typical_slip, share, model.slip_overshoot(named).ravel())
            fraction = typical_slip + static_share * (deeper - typical_slip)
            values["slip_fraction"] = fraction * top / np.maximum(top + held, 0.1 * top)
        return np.stack([channel.forward(values[channel.name]) for channel in channels])


def _tiled(conditions: RunConditions, draws: int) -> RunConditions:
    """The runs over and over, once a draw; numbered as sessions of the campaign they come from."""
    again: dict[str, Any] = {name: getattr(conditions, name) * draws for name in RunConditions.NAMES}
    again |= {name: np.tile(getattr(conditions, name), draws) for name in RunConditions.ARRAYS}
    return replace(conditions, **again)
