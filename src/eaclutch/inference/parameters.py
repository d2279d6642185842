"""The model's parameters with the priors of a config."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.priors import Priors
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.records import InputError


def with_priors(
    parameters: Mapping[str, Parameter],
    overrides: Mapping[str, Sequence[float]],
    elsewhere: Sequence[str] = (),
) -> dict[str, Parameter]:
    """``parameters`` and the hyperparameters, with ``overrides`` {name: [mean, sd]} in place of their priors.

    A parameter whose built-in prior is lognormal keeps that form, with the given mean and sd; others become
    normal. ``elsewhere``: further names that may stand in a config (of effects that are off). Raises InputError
    naming the key for an unknown name or an impossible prior.
    """
    known: dict[str, Parameter] = dict(HYPERPARAMETERS) | dict(parameters)
    for name, (mean, sd) in overrides.items():
        if name not in known:
            if name in elsewhere:
                continue
            raise InputError(
                f"priors.{name}", "there is no such parameter", f"give one of {', '.join(sorted(known))}"
            )
        known[name] = replace(known[name], prior=_prior(known[name], float(mean), float(sd)))
        Priors.of([known[name]])
    return known


def _prior(parameter: Parameter, mean: float, sd: float) -> Prior:
    if parameter.prior.distribution in ("lognormal", "loguniform") and mean > 0:
        variance = float(np.log1p((sd / mean) ** 2))
        return Prior("lognormal", mean * np.exp(-0.5 * variance), variance**0.5)
    if parameter.prior.distribution in ("lognormal", "loguniform"):
        raise InputError(
            f"priors.{parameter.name}", f"mean {mean:g} of a positive quantity", "give a positive mean"
        )
    return Prior("normal", mean, sd)
