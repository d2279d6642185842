"""From parameters to the data vector: one hypothesis' model, batched over parameter vectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from eaclutch.diagnosis.bench_channels import BenchEntries
from eaclutch.diagnosis.channels import Channel
from eaclutch.diagnosis.data import DataVector
from eaclutch.inference.priors import Priors
from eaclutch.physics.effect import Parameter
from eaclutch.physics.model import ClutchModel
from eaclutch.records import FloatArray, RunConditions

# A run that the model cannot follow (it pulls in, or never slips, while the bench measured a time) stands
# this far off on the comparison scale: bad, finite, and the same for every hypothesis.
UNPREDICTED = 0.5


class Forward:
    """Predictions of the data vector under one set of effects.

    ``priors`` holds the calibrated parameters first, then those of ``candidates`` (effects on top of the
    campaign's own model).
    """

    def __init__(self, model: ClutchModel, data: DataVector, candidates: Sequence[str] = ()):
        self.model, self.data, self.candidates = model, data, tuple(candidates)
        self.priors = Priors.of(tuple(p for p in model.parameters.values() if self._free(p.name)))

    def _free(self, name: str) -> bool:
        """Base effects' weights stay at one unless they are candidates; the force at switch-off is measured,
        so where a run stands in its stick-slip cycle is not a parameter here."""
        return name != "slip_phase" and (not name.endswith(".strength") or self.own(name))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.priors.parameters

    def own(self, name: str) -> bool:
        """Whether a parameter belongs to one of the candidates."""
        return name.split(".")[0] in self.candidates

    def predict(self, theta: FloatArray) -> FloatArray:
        """Entries (draws, entries) for parameters (draws, params) in natural units."""
        theta = np.atleast_2d(theta)
        named = {name: theta[:, i] for i, name in enumerate(self.priors.names)}
        runs = self.runs(named)
        flat = runs.reshape(len(theta), -1)
        return np.concatenate([flat @ self.data.average.T, self._bench(named, len(theta))], axis=1)

    def runs(self, named: dict[str, FloatArray]) -> FloatArray:
        """Run-level predictions on the comparison scale, (draws, channels, runs), finite throughout."""
        scaled = predict_scaled(self.model, self.data.conditions, named, self.data.channels)
        off = np.nan_to_num(self.data.run_values) + UNPREDICTED
        return np.where(np.isfinite(scaled), scaled, off)

    def _bench(self, named: dict[str, FloatArray], draws: int) -> FloatArray:
        bench: BenchEntries = self.data.bench
        out = np.zeros((draws, len(bench.values)))
        rows = np.flatnonzero(bench.block == "capacitance")
        if len(rows):
            out[:, rows] = np.log(self.model.capacitance(bench.setting[rows], bench.width[rows], named))
        rows = np.flatnonzero(bench.block == "permittivity")
        if len(rows):
            out[:, rows] = np.log(self.model.permittivity(bench.setting[rows], named))
        rows = np.flatnonzero(bench.block == "bursts")
        if len(rows):
            out[:, rows] = _burst_logs(named)
        return out


def predict_scaled(
    model: ClutchModel,
    conditions: RunConditions,
    named: Mapping[str, FloatArray],
    channels: Sequence[Channel],
) -> FloatArray:
    """Run-level predictions on the comparison scale, (draws, channels, runs); not-a-number where the model's
    status says that there is none."""
    prediction = model.predict(
        conditions, named, observables=[channel.name for channel in channels], on_invalid="status"
    )
    return np.stack([channel.forward(prediction.values[channel.name]) for channel in channels], axis=1)


def _burst_logs(named: dict[str, FloatArray]) -> FloatArray:
    """log frequency [Hz] and log damping ratio of the bare load cell's free swing, (draws, 2)."""
    k, m, b = named["stiffness"], named["mass"], named["damping"]
    ratio = b / (2.0 * np.sqrt(k * m))
    damped = np.sqrt(np.maximum(k / m * (1.0 - ratio**2), 1e-12)) / (2.0 * np.pi)
    return np.column_stack([np.log(damped), np.log(ratio)])
