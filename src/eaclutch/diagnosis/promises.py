"""What a further effect promises beside a fit, by its slopes: which fits are worth making."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.starts import scout_shifts
from eaclutch.diagnosis.study import Study


def promises(study: Study, fitted: HypothesisFit, names: Sequence[str]) -> dict[str, float]:
    """Nats that each effect of ``names`` promises beside a fit that lacks it: what the best of its scouted sizes takes
    off the misfit when all parameters of the fit follow linearly, less what it costs in prior."""
    tolerance, session = fitted.multipliers
    # a gap that one effect leaves is for the second one, not for wide tolerances
    usual = max(study.thresholds["multipliers"]["tolerance"]["values"])
    covariance = study.kernels.total(
        tolerance=min(tolerance, usual), session=session,
        signature=fitted.form, signature_tolerance=study.thresholds["signature_tolerance"],
    )  # fmt: skip
    linearised = replace(fitted.linearised, covariance=covariance)
    factor, w = cho_factor(linearised.marginal(), lower=True), linearised.w
    start = float(w @ cho_solve(factor, w))
    found = {}
    for name in names:
        if name not in fitted.effects:
            shift, cost = scout_shifts(study.forward((*fitted.effects, name)), fitted)
            trial = w - shift
            gain = 0.5 * (start - np.sum(trial.T * cho_solve(factor, trial.T), axis=0)) - cost
            found[name] = float(np.max(gain))
    return found
