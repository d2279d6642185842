"""One campaign under diagnosis: its data vector, its base fit, and the weighing of hypotheses against it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from eaclutch.diagnosis import bench_channels
from eaclutch.diagnosis.carried import carried
from eaclutch.diagnosis.cells import Cells, cells_of, native_variances, repeat_variance
from eaclutch.diagnosis.channels import channels_on
from eaclutch.diagnosis.condense import condense
from eaclutch.diagnosis.covariance import Kernels, kernels
from eaclutch.diagnosis.data import DataVector, build, estimated_preload
from eaclutch.diagnosis.drift import RepeatDrift, repeat_drift
from eaclutch.diagnosis.fit import fit_hypothesis, plain_fit_at
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.free_swing import charged, count_swings
from eaclutch.diagnosis.gaussian import Linearised, log_normal, posterior_mean
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.diagnosis.mode import find_mode
from eaclutch.diagnosis.nameless import Nameless, nameless_fit
from eaclutch.diagnosis.readings import of_the_reading
from eaclutch.diagnosis.remainder import Remainder, with_remainder
from eaclutch.diagnosis.result import CandidateResult, summarise
from eaclutch.diagnosis.session_moves import session_moves, with_sessions
from eaclutch.physics.effects import EFFECTS, LOOKALIKES, NAMED
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import OBSERVABLES
from eaclutch.records import (
    FloatArray,
    InputError,
    RunConditions,
)
from eaclutch.rig.table import conditions_from_runs

# Local error of the film's position: 1 us in a release time, half the cost of the default.
SOLVER_TOLERANCE = 1e-3
WORTH_OPENING = 3.0  # nats over the base model
SAME_PLACE = 1.0  # nats between two fits of one hypothesis that ended in the same place
SESSION_SPREADS = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0)


class Study:
    """Everything that hypotheses share; built once a job, deterministic.

    ``known``: what another job's study of the same inputs says of its own fits (``fits``); worked out without it.
    """

    def __init__(
        self,
        inputs: DiagnosisInputs,
        thresholds: Mapping[str, Any],
        seed: int = 1,
        known: Mapping[str, Any] | None = None,
    ):
        self.inputs, self.thresholds, self.seed = inputs, thresholds, seed
        self.priors = {**thresholds["priors"], **(inputs.priors or {})}
        for name in inputs.candidates:
            if name in LOOKALIKES:
                raise InputError(
                    f"diagnosis.candidates, {name}",
                    "is a lookalike, which is always weighed and never named",
                    "leave it out, or switch it on in model.effects",
                )
        every = inputs.candidates or NAMED
        self.candidates = tuple(name for name in every if name not in inputs.effects)
        self.lookalikes = tuple(name for name in LOOKALIKES if name not in inputs.effects)
        usable = conditions_from_runs(inputs.table, inputs.bench).run
        if len(usable) == 0:
            raise InputError(
                "runs.csv", "no usable run", "look at its flags and reasons; nothing can be diagnosed"
            )
        channels = [
            c
            for c in channels_on(inputs.bench)
            if c.resolvable and c.name in inputs.table and c.name in OBSERVABLES
        ]
        table = inputs.table[inputs.table["run"].isin(usable)].reset_index(drop=True)
        self.table, self.condensed = condense(table, len(channels))
        self.conditions: RunConditions = conditions_from_runs(self.table, inputs.bench)
        widths = [w for substrate in inputs.bench.substrates.values() for w in substrate.thickness]
        entries = bench_channels.summarise(inputs.readings, inputs.spectra, inputs.bursts, thresholds, widths)
        cell = inputs.bench.load_cell
        rate = cell.stiffness.mean * inputs.bench.stage_speed
        quarter = 0.5 * np.pi * np.sqrt(cell.mass.mean / cell.stiffness.mean)

        def data(*explained: FloatArray) -> DataVector:
            return build(
                self.table, self.conditions, entries, channels, thresholds, rate, quarter, *explained
            )

        first = data()
        self.known = known
        self.first_fit: dict[str, float] = {} if known is None else dict(known["first_fit"])
        if first.run_entries:
            channels = list(first.channels)
            first = data(*self._explained(first))
        self.data = first
        if self.data.run_entries == 0:
            raise InputError("runs.csv", "no observable can be compared", "look at its flags and reasons")
        moves = session_moves(self.forward(()), self.first_fit, thresholds["session_together"])
        self.kernels: Kernels = with_sessions(kernels(self.data, thresholds), self.data.session, moves)
        variances, self.dof = native_variances(self.table, self.data)
        self.cells: Cells = cells_of(self.data, variances)
        self.repeat_variance = repeat_variance(self.data, variances)
        self.preload = estimated_preload(self.table, self.conditions)
        self.swings = count_swings(self.table)

    def model(self, effects: Sequence[str] = ()) -> ClutchModel:
        """The campaign's model with ``effects`` on top, in the library's order."""
        chosen = set(self.inputs.effects) | set(effects)
        names = tuple(name for name in EFFECTS if name in chosen)
        return ClutchModel(
            self.inputs.bench, names, tolerance=SOLVER_TOLERANCE, **(self.inputs.model_options or {})
        )

    def _explained(self, first: DataVector) -> tuple[FloatArray, FloatArray]:
        """Run-level predictions of the base model after a first fit, and what they are uncertain by, (channels, runs)
        each."""
        forward = Forward(self.model(), first, (), self.priors)
        if self.known is None:
            fitted = fit_hypothesis(forward, first, kernels(first, self.thresholds), self.thresholds)
            self.first_fit = fitted.parameters
        else:
            _in_order(self.first_fit, forward)
        return carried(forward, self.table, self.first_fit)

    def generator(self, *stream: int) -> np.random.Generator:
        """A generator of its own for each purpose: the same whatever else ran before."""
        return np.random.default_rng([self.seed, *stream])

    @cached_property
    def drift(self) -> RepeatDrift | None:
        """Repeats that follow the run order, where they do."""
        return repeat_drift(self.data, self.preload, self.thresholds, self.generator(17))

    @cached_property
    def base(self) -> HypothesisFit:
        """The fit of the campaign's own model."""
        forward = self.forward(())
        if self.known is None:
            return fit_hypothesis(forward, self.data, self.kernels, self.thresholds, seeds=self.first_fit)
        found = self.known["base_fit"]
        tolerance, session = found["size"]
        return plain_fit_at(
            forward, self.data, self.kernels, self.thresholds,
            _in_order(found["at"], forward), (tolerance, session), found["converged"],
        )  # fmt: skip

    @property
    def fits(self) -> dict[str, Any]:
        """What spares another job this study's fits: ``first_fit``, {parameter: value}, and ``base_fit``: its mode,
        {parameter: value in prior coordinates}, the multipliers that it was sought with, and whether it was found."""
        mode = self.base.mode
        at = dict(zip(mode.names, mode.u.tolist(), strict=True))
        base = {"at": at, "size": list(self.base.size), "converged": mode.converged}
        return {"first_fit": self.first_fit, "base_fit": base}

    @cached_property
    def nameless(self) -> Nameless:
        """The nameless competitor beside the base model."""
        return nameless_fit(self.base.linearised, self.data, self.kernels, self.thresholds)

    @cached_property
    def session_spread(self) -> float:
        """This campaign's own spread between sessions, as a multiple of the assumed one: the most probable where
        the base model holds."""
        tolerance = np.array([self.nameless.factors[block] for block in self.data.block])
        prior = self.sound.jacobian @ self.sound.jacobian.T
        scores = [
            log_normal(self.sound.w, self.kernels.total(tolerance=tolerance, session=s) + prior)
            for s in SESSION_SPREADS
        ]
        return SESSION_SPREADS[int(np.argmax(scores))]

    @cached_property
    def sound(self) -> Linearised:
        """The base model fitted where it holds: blocks that the nameless competitor finds off count less.

        A plain fit spreads one block's misfit over all of them, through the parameters they share; this one says
        where the gap is.
        """
        base = self.base
        if all(factor == 1.0 for factor in self.nameless.factors.values()):
            return base.linearised
        forward, covariance = self.forward(()), self.nameless.linearised.covariance
        mode = find_mode(forward, self.data.values, lambda theta: covariance, base.mode.u)
        w = self.data.values - mode.predicted + mode.jacobian @ mode.u
        return Linearised(w, mode.jacobian, covariance)

    @cached_property
    def readings(self) -> dict[str, float]:
        """How the bench reads forces, {parameter: value in prior coordinates}, from where the base model holds.

        A condition that is left out is still read by the same bench, and no hypothesis may bend a zero to explain
        its gap away: what is left out is predicted with these.
        """
        mean = posterior_mean(self.sound)
        return {n: float(mean[i]) for i, n in enumerate(self.base.mode.names) if of_the_reading(n)}

    def forward(self, effects: Sequence[str]) -> Forward:
        return Forward(self.model(effects), self.data, effects, self.priors)

    def fit(
        self,
        effects: Sequence[str],
        seeds: Mapping[str, float] | None = None,
        beyond: HypothesisFit | None = None,
        *,
        afresh: tuple[float, float] | None = None,
    ) -> HypothesisFit:
        """Joint fit with ``effects`` on top of the campaign's model; ``beyond``: the fit of one of two effects, on top
        of which the other is tried; ``afresh``: from draws of all parameters, not from where the base fit stands, and
        around a gap of that size (multipliers of tolerance and session)."""
        if not effects:
            return self.base
        return fit_hypothesis(
            self.forward(effects), self.data, self.kernels, self.thresholds,
            base=None if afresh else self.base, beyond=beyond, seeds=seeds, size=afresh or (1.0, 1.0),
        )  # fmt: skip

    def weigh(
        self,
        effects: Sequence[str],
        seeds: Mapping[str, float] | None = None,
        beyond: HypothesisFit | None = None,
        *,
        afresh: tuple[float, float] | None = None,
    ) -> CandidateResult:
        """Fit and score one hypothesis; ``seeds``: parameters to start from as well; ``beyond``, ``afresh``: as
        for fit."""
        fitted = self.fit(effects, seeds, beyond, afresh=afresh)
        result = summarise(
            fitted, self.forward(effects), self.data, self.cells, self._open(fitted), self._without(fitted),
            self.readings, self.generator(7),
        )  # fmt: skip
        if not effects and self.drift is not None:
            result = replace(result, repeat_drift=self.drift.evidence)
        return charged(result, self.inputs.effects, self.swings, self.thresholds)

    def _without(self, fitted: HypothesisFit) -> tuple[float, float]:
        """Evidence of the base model, and with a nameless remainder, fitted once more from the calibrated parameters
        of a better fit: what an effect gains must not be that its fit ended in a better place."""
        plain, remainder = self.base.log_evidence, self.remainder.log_evidence
        if not fitted.effects or fitted.log_evidence < plain + WORTH_OPENING:
            return plain, remainder
        again = fit_hypothesis(
            self.forward(()), self.data, self.kernels, self.thresholds,
            base=self.base, seeds=fitted.parameters, size=self.base.size,
        )  # fmt: skip
        gain = max(again.log_evidence - plain, 0.0)
        if gain < SAME_PLACE:
            return plain + gain, remainder + gain
        return plain + gain, max(remainder, self._open(again).log_evidence)

    @cached_property
    def remainder(self) -> Remainder:
        """Beside the base model: what an effect that the library lacks would have to be."""
        return with_remainder(
            self.forward(()), self.data, self.kernels, self.thresholds, self.base, self.nameless
        )

    def _open(self, fitted: HypothesisFit) -> Remainder:
        """A fit with a nameless remainder; worked out only where the effects explain something at all."""
        if fitted is self.base:
            return self.remainder
        if fitted.effects and fitted.log_evidence < self.base.log_evidence + WORTH_OPENING:
            return Remainder(fitted.log_evidence, np.zeros(len(self.data)))
        return with_remainder(self.forward(fitted.effects), self.data, self.kernels, self.thresholds, fitted)


def _in_order(named: Mapping[str, float], forward: Forward) -> FloatArray:
    """Values (params,) in the order of ``forward``'s parameters. Raises InputError where they are not the same."""
    names = forward.priors.names
    if set(named) != set(names):
        raise InputError("gap.json", "is of another model or campaign", "run diagnosis-gap again")
    return np.array([named[name] for name in names])
