"""How much each parameter owes to its prior, and whether prior and data contradict each other.

All in the priors' normal coordinates u, where every prior is N(0, 1). Power scaling (Kallioinen et al. 2023,
doi:10.1007/s11222-023-10366-5) to first order: raising prior or likelihood to the power 2^t moves the posterior
mean by t ln 2 Cov(u, log prior or log likelihood).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from eaclutch.inference.priors import Priors
from eaclutch.records import FloatArray

LEAST_CONTRACTION = 0.5  # of the variance: below it the prior says more than the data
STRONG_PULL = 3.0  # prior sds of what the data alone would say
NOTICEABLE = 0.3  # posterior sds by which the mean moves when the prior counts twice


def sensitivity(priors: Priors, theta: FloatArray, log_density: FloatArray) -> dict[str, dict[str, Any]]:
    """Measures by parameter from draws theta (draws, params) and their log density (draws,) in normal coordinates.

    contraction: 1 - posterior variance / prior variance. prior_sensitivity, likelihood_sensitivity: how many
    posterior sds the mean moves if the prior (the likelihood) counted twice. pull: how far, in standard errors,
    what the data alone say lies from the prior's centre. driven_by: data, prior, or both. conflict: whether the
    pull is strong while the prior still matters.
    """
    u = priors.to_normal(theta)
    log_prior = -0.5 * np.sum(u**2, axis=1)
    rows = {}
    for i, name in enumerate(priors.names):
        mean, sd = float(np.mean(u[:, i])), float(np.std(u[:, i]))
        to_prior = _moved(u[:, i], log_prior)
        to_data = _moved(u[:, i], log_density - log_prior)
        contraction = 1.0 - sd**2
        # Gaussian: mean = (1 - sd^2) m and 1 / sd^2 = 1 + 1 / s^2 for what the data alone would say, m +- s
        pull = mean / np.sqrt(contraction) if contraction > 0.02 else 0.0
        conflict = abs(pull) > STRONG_PULL
        driven = "data" if contraction > LEAST_CONTRACTION else "prior"
        if driven == "data" and (conflict or to_prior > NOTICEABLE):
            driven = "both"
        rows[name] = {
            "contraction": contraction, "prior_sensitivity": to_prior, "likelihood_sensitivity": to_data,
            "pull": float(pull), "driven_by": driven, "conflict": bool(conflict),
        }  # fmt: skip
    return rows


def _moved(values: FloatArray, weight: FloatArray) -> float:
    """Posterior sds by which the mean of ``values`` (draws,) moves when e^weight counts twice."""
    sd = float(np.std(values))
    finite = np.isfinite(weight)
    if sd == 0 or finite.sum() < 2:
        return 0.0
    covariance = float(
        np.mean((values[finite] - values[finite].mean()) * (weight[finite] - weight[finite].mean()))
    )
    return float(abs(covariance) * np.log(2) / sd)


def warnings_of(rows: dict[str, dict[str, Any]]) -> list[str]:
    """A sentence for every parameter whose data contradict its prior, and one for those that the prior drives."""
    found = [
        f"{name}: the data pull {row['pull']:+.1f} standard errors away from the prior"
        for name, row in rows.items()
        if row["conflict"]
    ]
    prior_led = [name for name, row in rows.items() if row["driven_by"] == "prior"]
    if prior_led:
        found.append(f"driven by the prior: {', '.join(prior_led)}")
    return found
