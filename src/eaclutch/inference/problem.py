"""A problem binds data, model and priors; the sampler sees a vectorised callable and nothing else."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from eaclutch.inference.priors import Priors
from eaclutch.records import FloatArray

Stage = Literal["contact", "dielectric", "load_cell", "force"]
STAGES: tuple[Stage, ...] = ("dielectric", "load_cell", "contact", "force")


@dataclass(frozen=True)
class Problem:
    """What a stage's posterior is made of. theta is (draws, params) in natural units throughout.

    log_likelihood(theta) -> (draws,), -inf where theta cannot be. ``None``: no data, the posterior is the prior.
    pointwise(theta) -> (draws, points): log density of each datum given all the others (and theta).
    predictive(theta, rng, posterior) -> (draws, points): replicated data;
    ``posterior`` False: theta are prior draws. observed (points,): the data, in ``data_unit``,
    with coordinates ``coords`` {name: (points,)}. derived(theta, rng) -> {name: (draws,)}: further variables
    of the posterior (marginalised levels drawn again, constants). ``notes``: what a reader must know.
    ``wider``: the same data under a law with one parameter more, the last one, at whose neutral value both laws are
    the same: a check of this one.
    ``redrawn``: parameters of several modes that leave the others where they are (moves.Redraw).
    ``fingerprint``: hashes of data, model and settings by name; ``sampled`` hyperparameters are part of priors.
    """

    stage: str
    priors: Priors
    log_likelihood: Callable[[FloatArray], FloatArray] | None = None
    pointwise: Callable[[FloatArray], FloatArray] | None = None
    predictive: Callable[..., FloatArray] | None = None
    observed: FloatArray | None = None
    data_name: str = "y"
    data_unit: str = "1"
    coords: Mapping[str, Any] = field(default_factory=dict)
    derived: Callable[[FloatArray, np.random.Generator], Mapping[str, FloatArray]] | None = None
    derived_units: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    wider: Problem | None = None
    redrawn: tuple[str, ...] = ()
    fingerprint: Mapping[str, str] = field(default_factory=dict)

    @property
    def has_data(self) -> bool:
        return self.log_likelihood is not None

    def log_density(self, u: FloatArray) -> FloatArray:
        """Log posterior density (draws,) in the priors' standard normal coordinates u (draws, params)."""
        u = np.asarray(u, dtype=float)
        value = -0.5 * np.sum(u**2, axis=-1)
        if self.log_likelihood is not None:
            value = value + self.log_likelihood(self.priors.from_normal(u))
        return np.where(np.isnan(value), -np.inf, value)

    def fingerprints(self) -> dict[str, str]:
        """What a checkpoint is valid for: data, code and settings of the stage, priors, parameter order."""
        priors = [
            (p.name, p.prior.distribution, p.prior.a, p.prior.b, *p.bounds) for p in self.priors.parameters
        ]
        return {
            **self.fingerprint,
            "prior": digest(sorted(priors)),
            "parameter order": digest(list(self.priors.names)),
        }


def digest(value: Any) -> str:
    """SHA-256 of arrays (bytes, shape) and plain values (canonical JSON), nested in dicts and lists."""
    hasher = hashlib.sha256()
    _feed(hasher, value)
    return hasher.hexdigest()


def _feed(hasher: Any, value: Any) -> None:
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biuf":
            _feed(hasher, value.astype(str).tolist())
            return
        hasher.update(f"{value.dtype.str}{value.shape}".encode())
        hasher.update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, Mapping):
        for key in sorted(value):
            hasher.update(f"{key}:".encode())
            _feed(hasher, value[key])
    elif isinstance(value, (list, tuple)):
        hasher.update(f"[{len(value)}".encode())
        for item in value:
            _feed(hasher, item)
    else:
        hasher.update(json.dumps(value, default=repr, sort_keys=True).encode())
