"""A hypothesis once fitted, and how far its effects move the prediction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.gaussian import Linearised, posterior_sd
from eaclutch.diagnosis.mode import Mode
from eaclutch.physics.effects import EFFECTS
from eaclutch.records import FloatArray

FAR_TAIL = 4.0  # prior sds


@dataclass(frozen=True)
class HypothesisFit:
    """A fitted hypothesis.

    effects: the candidates on top of the campaign's model. linearised: at the mode, with the covariance of
    the most probable multipliers; usual: the same with no wider a tolerance than an evidence may take.
    residual (entries,): measured less predicted at the mode. signature (entries,): how far the effects themselves
    move the prediction; form: of that, what another form of their laws might move. multipliers: the most probable
    (tolerance, session). log_evidence: nats, averaged over the multipliers. peak: that of the most probable
    multipliers, however wide; fits of one hypothesis from different starts are compared by it. size: the multipliers at
    which its mode was found.
    """

    effects: tuple[str, ...]
    mode: Mode
    linearised: Linearised
    usual: Linearised
    residual: FloatArray
    signature: FloatArray
    form: FloatArray
    multipliers: tuple[float, float]
    log_evidence: float
    peak: float
    size: tuple[float, float]

    @property
    def parameters(self) -> dict[str, float]:
        return dict(zip(self.mode.names, self.mode.theta.tolist(), strict=True))

    @property
    def sd(self) -> FloatArray:
        """Posterior sd of the parameters (params,), natural units, at the most probable multipliers."""
        # in the far tail of a bounded prior the slope is lost to the bound
        slope = self.mode.priors.slope(np.clip(self.mode.u, -FAR_TAIL, FAR_TAIL))
        found: FloatArray = np.abs(slope) * posterior_sd(self.linearised)
        return found


def fitted_parameters(forward: Forward, fitted: HypothesisFit) -> tuple[dict[str, Any], dict[str, Any]]:
    """The effects' own parameters (of several effects with their names in front) and the calibrated ones, {name: {mean,
    sd, unit}}, natural units; of these the prior sds that they are off their prior's median, ``prior_sds``, too."""
    own, calibrated = {}, {}
    for parameter, mean, sd, u in zip(
        forward.parameters,
        fitted.mode.theta.tolist(),
        fitted.sd.tolist(),
        fitted.mode.u.tolist(),
        strict=True,
    ):
        entry = {"mean": mean, "sd": sd, "unit": parameter.unit}
        if forward.own(parameter.name):
            own[parameter.name if len(fitted.effects) > 1 else parameter.name.split(".", 1)[1]] = entry
        else:  # of an effect that the campaign's own model has, too
            calibrated[parameter.name] = entry | {"prior_sds": u}
    return own, calibrated


def own_signature(forward: Forward, theta: FloatArray) -> FloatArray:
    """How far the candidates move the prediction from neutral at ``theta``, (entries,)."""
    if not forward.candidates:
        return np.zeros(len(forward.data))
    return effect_shifts(forward, theta[None], neutral_parameters(forward, theta), forward.candidates)[0]


def effect_shifts(
    forward: Forward, theta: FloatArray, neutral: FloatArray, switched: Sequence[str]
) -> FloatArray:
    """How far ``theta`` (draws, params) moves the entries from ``neutral`` (params,), (draws, entries), where what is
    held of the effects ``switched`` is neutral, too: a law that is on or off has no slope, and still acts."""
    held = {p.name: np.array([p.neutral]) for p in forward.held
            if p.neutral is not None and p.name.split(".")[0] in switched}  # fmt: skip
    off = forward.representative.predict_named(forward.named(neutral[None]) | held, 1)
    moved: FloatArray = forward.representative.predict(theta) - off
    return moved


def form_signature(forward: Forward, theta: FloatArray) -> FloatArray:
    """``own_signature`` of the candidates whose law might have another form, (entries,)."""
    loose = [
        i
        for i, parameter in enumerate(forward.parameters)
        if forward.own(parameter.name) and not EFFECTS[parameter.name.split(".")[0]].exact
    ]
    if not loose:
        return np.zeros(len(forward.data))
    return effect_shifts(forward, theta[None], neutral_parameters(forward, theta, loose), ())[0]


def neutral_parameters(forward: Forward, theta: FloatArray, which: Sequence[int] | None = None) -> FloatArray:
    """``theta`` with the candidates' parameters, or ``which`` of them, at the value that switches an effect off."""
    out = np.array(theta, dtype=float)
    for i, parameter in enumerate(forward.parameters):
        if forward.own(parameter.name) and parameter.neutral is not None and (which is None or i in which):
            out[i] = parameter.neutral
    return out
