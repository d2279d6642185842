"""One campaign under diagnosis: its base fit, and the weighing of hypotheses against it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from eaclutch.diagnosis.contact_law import with_contact_law
from eaclutch.diagnosis.drift import RepeatDrift, repeat_drift
from eaclutch.diagnosis.fit import fit_hypothesis, plain_fit_at
from eaclutch.diagnosis.free_swing import charged
from eaclutch.diagnosis.gaussian import Linearised, log_normal, posterior_mean
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.diagnosis.mode import find_mode
from eaclutch.diagnosis.nameless import Nameless, nameless_fit
from eaclutch.diagnosis.prepared import PreparedCampaign, in_order
from eaclutch.diagnosis.readings import of_the_readings
from eaclutch.diagnosis.remainder import Remainder, with_remainder
from eaclutch.diagnosis.result import CandidateResult, summarise

WORTH_OPENING = 3.0  # nats over the base model
SAME_PLACE = 1.0  # nats between two fits of one hypothesis that ended in the same place
SESSION_SPREADS = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0)


class Study(PreparedCampaign):
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
        super().__init__(inputs, thresholds, known)
        self.seed = seed
        self._constants: dict[tuple[str, ...], dict[str, Any]] = {}

    def generator(self, *stream: int) -> np.random.Generator:
        """A generator of its own for each purpose: the same whatever else ran before."""
        return np.random.default_rng([self.seed, *stream])

    @cached_property
    def drift(self) -> RepeatDrift | None:
        """Repeats that follow the run order, where they do."""
        return repeat_drift(self.data, self.thresholds, self.generator(17))

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
            in_order(found["at"], forward), (tolerance, session), found["converged"],
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

        A condition that is left out is still read by the same bench: the base model predicts it with these.
        """
        return of_the_readings(self.base.mode.names, posterior_mean(self.sound))

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
        # effects have zeros of their own: the base model's bend with the gap that it leaves
        readings = of_the_readings(fitted.mode.names, fitted.mode.u) if effects else self.readings
        result = summarise(
            fitted, self.forward(effects), self.data, self.cells, self._open(fitted), self._without(fitted),
            readings, self.generator(7),
        )  # fmt: skip
        if not effects and self.drift is not None:
            result = replace(result, repeat_drift=self.drift.evidence)
        return charged(result, self.inputs.effects, self.swings, self.thresholds)

    def constants(self, result: CandidateResult) -> dict[str, Any]:
        """Calibrated parameters of a weighed hypothesis, as they are known where the contact law is free."""
        if result.effects not in self._constants:
            self._constants[result.effects] = with_contact_law(self, result)
        return self._constants[result.effects]

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
