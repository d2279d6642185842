"""What is known of the calibrated parameters where the contact law may be another one than Greenwood-Williamson's.

Hypotheses are weighed by that law. The base model and the verdict are then fitted once more from where they stand with
the contact law free (``laws.bent``): names and probabilities do not depend on it, and the stiffness and roughness of
a surface whose heights are not Gaussian are not said to be known better than they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from eaclutch.diagnosis.fit import fit_from
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.hypothesis import HypothesisFit, fitted_parameters
from eaclutch.diagnosis.prepared import PreparedCampaign
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.physics.parameters import CONTACT_LAW_BEND


def fit_contact_law(
    study: PreparedCampaign, effects: Sequence[str], named: Mapping[str, float], size: tuple[float, float]
) -> tuple[Forward, HypothesisFit]:
    """The fit of ``effects`` with the contact law free, and its model, from ``named`` parameters, those of the fit
    without, and its multipliers ``size`` (tolerance, session)."""
    forward = study.forward(effects, contact_law=True)
    return forward, fit_from(forward, study.data, study.kernels, study.thresholds, named, size)


def with_contact_law(study: PreparedCampaign, result: CandidateResult) -> dict[str, Any]:
    """``CandidateResult.calibrated`` with the contact law free, its bend among them."""
    return fitted_parameters(*fit_contact_law(study, result.effects, result.named, result.multipliers))[1]


def other_contact_law(
    calibrated: Mapping[str, Mapping[str, Any]], thresholds: Mapping[str, Any]
) -> list[str]:
    """A caveat where ``calibrated`` parameters (``with_contact_law``) have the contact law bent by more than it may be
    expected to."""
    bend = calibrated[CONTACT_LAW_BEND]
    if abs(bend["prior_sds"]) < thresholds["caveats"]["contact_law_prior_sds"]:
        return []
    return [
        f"the contact law departs from Greenwood-Williamson's: with the gap the logarithm of the load curves by "
        f"{bend['mean']:+.2f} +- {bend['sd']:.2f} more (+0.80 for exponentially distributed heights), which counts as "
        "no effect"
    ]
