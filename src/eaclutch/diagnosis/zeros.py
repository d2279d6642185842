"""Zeros of the load cell that a run does not show: one free offset a session, for the runs that still hold it.

Most runs begin in contact, so the force without contact is not in their log, and their friction before the
voltage, their force at switch-off and every ratio of forces still contain the session's zero (tens of mN).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from eaclutch.diagnosis.channels import Channel
from eaclutch.diagnosis.data import DataVector
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.physics.model import ClutchModel
from eaclutch.records import FloatArray, RunConditions

ZERO_SD = 0.025  # N, between sessions (rig: tens of mN)
LARGEST_ZERO = 0.2  # N
PREFIX = "force_zero_"


@dataclass(frozen=True)
class Zeros:
    """Sessions with an unknown zero, and which run holds which (runs,), -1 for none."""

    sessions: tuple[str, ...]
    index: np.ndarray

    @classmethod
    def of(cls, data: DataVector) -> Zeros:
        """The unknown zeros of a campaign."""
        held = [s for s, unknown in zip(data.conditions.session, data.zero_unknown, strict=True) if unknown]
        sessions = tuple(dict.fromkeys(held))
        index = [
            sessions.index(s) if unknown else -1
            for s, unknown in zip(data.conditions.session, data.zero_unknown, strict=True)
        ]
        return cls(sessions, np.array(index, dtype=int))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """One parameter a session, [N]."""
        return tuple(
            Parameter(f"{PREFIX}{s}", "N", (-LARGEST_ZERO, LARGEST_ZERO), 0.0, Prior("normal", 0.0, ZERO_SD))
            for s in self.sessions
        )

    def select(self, rows: np.ndarray) -> Zeros:
        """The same for some of the runs."""
        return Zeros(self.sessions, self.index[rows])

    def without(self, named: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Parameters by name, without the zeros: what the model knows."""
        return {name: value for name, value in named.items() if not name.startswith(PREFIX)}

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
        draws = len(next(iter(known.values())))
        zeros = np.zeros((draws, len(self.sessions)))
        for i, session in enumerate(self.sessions):
            zeros[:, i] = named.get(f"{PREFIX}{session}", 0.0)
        out = np.empty((draws, len(channels), len(conditions)))
        distinct, which = np.unique(zeros, axis=0, return_inverse=True)
        for i, zero in enumerate(distinct):
            rows = np.flatnonzero(which.ravel() == i)
            part = {name: value[rows] for name, value in known.items()}
            out[rows] = self._predict_at(model, conditions, part, channels, zero)
        return out

    def _predict_at(
        self,
        model: ClutchModel,
        conditions: RunConditions,
        named: Mapping[str, FloatArray],
        channels: Sequence[Channel],
        zero: FloatArray,
    ) -> FloatArray:
        held = np.where(self.index >= 0, np.append(zero, 0.0)[self.index], 0.0)
        true = replace(
            conditions,
            friction_before=conditions.friction_before - held,
            switch_off_force=conditions.switch_off_force - held,
        )
        names = [channel.name for channel in channels]
        wanted = names if "shear_capacity_n" in names else [*names, "shear_capacity_n"]
        values = dict(model.predict(true, named, observables=wanted, on_invalid="status").values)
        if "slip_fraction" in names:
            # read as the drop over a force that still holds the zero
            top = np.maximum(values["shear_capacity_n"] + true.friction_before, 1e-3)
            values["slip_fraction"] = values["slip_fraction"] * top / np.maximum(top + held, 0.1 * top)
        return np.stack([channel.forward(values[channel.name]) for channel in channels], axis=1)
