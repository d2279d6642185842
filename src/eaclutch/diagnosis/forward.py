"""From parameters to the data vector: one hypothesis' model, batched over parameter vectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from eaclutch.diagnosis.bench_channels import BenchEntries
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.readings import Readings
from eaclutch.inference.priors import Priors
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.parameters import CONTACT_LAW_BEND
from eaclutch.records import FloatArray

# A run that the model cannot follow (it pulls in, or never slips, while the bench measured a time) stands
# this far off on the comparison scale: bad, finite, and the same for every hypothesis.
UNPREDICTED = 0.5
# How a campaign's only session differs from others is the force multiplier's and the friction's to say.
ONLY_SESSION = "session_drift.offset_1"
UNDAMPED = 1e-6  # damping ratio; a fit may go to the bound of no damping, which has no logarithm


class Forward:
    """Predictions of the data vector under one set of effects.

    ``priors`` holds the free parameters: the calibrated ones and those of ``candidates`` (effects on top of the
    campaign's own model), without those that move nothing in this campaign; these are ``held`` at their default.
    ``contact_law``: whether the contact law may bend.
    """

    def __init__(
        self,
        model: ClutchModel,
        data: DataVector,
        candidates: Sequence[str] = (),
        priors: Mapping[str, Sequence[float]] | None = None,
        contact_law: bool = False,
    ):
        self.model, self.data, self.candidates = model, data, tuple(candidates)
        self.fixed = {"slip_phase"} if contact_law else {"slip_phase", CONTACT_LAW_BEND}
        free = [_with_prior(p, priors or {}) for p in model.parameters.values() if self._free(p.name)]
        self.readings = Readings.of(data)
        self.held: tuple[Parameter, ...] = ()
        if self.candidates:
            own = [p for p in free if self.own(p.name)]
            only = {ONLY_SESSION} if len(set(data.conditions.session)) < 2 else set()
            idle = only | self._idle([p for p in own if p.name not in only])
            self.held = tuple(p for p in free if p.name in idle)
            free = [p for p in free if p.name not in idle]
        self.priors = Priors.of((*free, *self.readings.parameters))

    def own(self, name: str) -> bool:
        """Whether a parameter belongs to one of the candidates."""
        return "." in name and name.split(".")[0] in self.candidates

    def _free(self, name: str) -> bool:
        """Base effects' weights stay at one unless they are candidates; the force at switch-off is measured,
        so where a run stands in its stick-slip cycle is not a parameter here."""
        return name not in self.fixed and (not name.endswith(".strength") or self.own(name))

    def _idle(self, own: Sequence[Parameter]) -> set[str]:
        """Names of own parameters that move no entry (the offset of a session that this campaign lacks)."""
        priors = Priors.of(tuple(own))
        points = np.concatenate([np.full((1, len(own)), 0.7), 0.7 + 0.6 * np.eye(len(own))])
        theta = priors.from_normal(points)
        found = self.representative.predict_named(
            {n: theta[:, i] for i, n in enumerate(priors.names)}, len(theta)
        )
        moved = np.max(np.abs(found[1:] - found[0]), axis=1) > 1e-7
        return {name for name, moves in zip(priors.names, moved, strict=True) if not moves}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.priors.parameters

    @cached_property
    def representative(self) -> RepresentativeForward:
        """The same model on one run an entry: a fraction of the cost, for derivatives and scouting."""
        return RepresentativeForward(self)

    def named(self, theta: FloatArray) -> dict[str, FloatArray]:
        """Parameters (draws, params) by name."""
        return {name: theta[:, i] for i, name in enumerate(self.priors.names)}

    def predict(self, theta: FloatArray) -> FloatArray:
        """Entries (draws, entries) for parameters (draws, params) in natural units."""
        theta = np.atleast_2d(theta)
        named = self.named(theta)
        flat = self.runs(named).reshape(len(theta), -1)
        return np.concatenate([flat @ self.data.average.T, self.bench(named, len(theta))], axis=1)

    def runs(self, named: Mapping[str, FloatArray]) -> FloatArray:
        """Run-level predictions on the comparison scale, (draws, channels, runs), finite throughout."""
        scaled = self._scaled(named)
        off = np.nan_to_num(self.data.run_values) + UNPREDICTED
        return np.where(np.isfinite(scaled), scaled, off)

    def unpredicted(self, named: Mapping[str, FloatArray]) -> np.ndarray:
        """Where (draws, channels, runs) the model has no number to say."""
        return ~np.isfinite(self._scaled(named))

    def _scaled(self, named: Mapping[str, FloatArray]) -> FloatArray:
        return self.readings.predict(self.model, self.data.conditions, named, self.data.channels)

    def bench(self, named: Mapping[str, FloatArray], draws: int) -> FloatArray:
        """Bench entries (draws, bench entries) on the comparison scale."""
        bench: BenchEntries = self.data.bench
        out = np.zeros((draws, len(bench.values)))
        named = self.readings.without(named)
        rows = np.flatnonzero(bench.block == "capacitance")
        if len(rows):
            capacitance = self.model.capacitance(bench.setting[rows], bench.width[rows], named)
            out[:, rows] = np.log(np.maximum(capacitance, 1e-15))
        rows = np.flatnonzero(bench.block == "permittivity")
        if len(rows):
            out[:, rows] = np.log(self.model.permittivity(bench.setting[rows], named))
        rows = np.flatnonzero(bench.block == "bursts")
        if len(rows):
            full = {name: np.broadcast_to(named.get(name, self.model.parameters[name].default), draws)
                    for name in ("stiffness", "mass", "damping")}  # fmt: skip
            out[:, rows] = _burst_logs(full)
        return out


class RepresentativeForward:
    """Predictions of the data vector from one run an entry: of those that the entry averages, the one nearest to
    their median force at switch-off (a run that is not used may stand where no other does, and must not speak for
    them). Good for differences, not for residuals."""

    def __init__(self, full: Forward):
        self.full = full
        data = full.data
        count = len(data.conditions)
        force = np.nan_to_num(data.conditions.switch_off_force)
        chosen = []
        for i in range(data.run_entries):
            rows = data.average.indices[data.average.indptr[i] : data.average.indptr[i + 1]] % count
            rows = np.sort(rows)
            chosen.append(rows[int(np.argmin(np.abs(force[rows] - np.median(force[rows]))))])
        self.rows, self.place = np.unique(np.array(chosen, dtype=int), return_inverse=True)
        self.conditions = data.conditions.select(self.rows)
        self.channel = np.array(
            [[c.name for c in data.channels].index(n) for n in data.channel[: data.run_entries]]
        )

    def predict(self, theta: FloatArray) -> FloatArray:
        """Entries (draws, entries) for parameters (draws, params) in natural units."""
        theta = np.atleast_2d(theta)
        return self.predict_named(self.full.named(theta), len(theta))

    def predict_named(self, named: Mapping[str, FloatArray], draws: int) -> FloatArray:
        """The same for parameters by name; missing ones take their default."""
        full = self.full
        scaled = full.readings.select(self.rows).predict(
            full.model, self.conditions, named, full.data.channels
        )
        entries = scaled[:, self.channel, self.place]
        off = full.data.values[: full.data.run_entries] + UNPREDICTED
        entries = np.where(np.isfinite(entries), entries, off)
        return np.concatenate([entries, self.full.bench(named, draws)], axis=1)


def _with_prior(parameter: Parameter, priors: Mapping[str, Sequence[float]]) -> Parameter:
    """The parameter with the normal prior (mean, sd) that ``priors`` gives it, if it does."""
    if parameter.name not in priors:
        return parameter
    mean, sd = priors[parameter.name]
    return replace(parameter, prior=Prior("normal", float(mean), float(sd)))


def _burst_logs(named: Mapping[str, FloatArray]) -> FloatArray:
    """log frequency [Hz] and log damping ratio of the bare load cell's free swing, (draws, 2)."""
    k, m, b = named["stiffness"], named["mass"], named["damping"]
    ratio = np.maximum(b / (2.0 * np.sqrt(k * m)), UNDAMPED)
    damped = np.sqrt(np.maximum(k / m * (1.0 - ratio**2), 1e-12)) / (2.0 * np.pi)
    return np.column_stack([np.log(damped), np.log(ratio)])
