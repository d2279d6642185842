"""Priors of a parameter vector: density, draws, and the map that makes every one a standard normal.

The map ``theta = from_normal(u)`` takes a vector u of independent standard normals to the prior. Samplers and
Laplace fits work in u: no bounds, all scales one, and a fit without data falls back on the prior by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, ndtri

from eaclutch.physics.effect import Parameter, Prior
from eaclutch.records import FloatArray, InputError

# Prior mass outside the bounds below which the prior counts as not truncated: the map stays linear (or
# exponential) then, and remains exact when data pull a parameter many prior sds away.
NEGLIGIBLE_MASS = 1e-5
FARTHEST = 8.0  # |u| beyond which probabilities cannot be told from 0 and 1 in double precision


@dataclass(frozen=True)
class _Base:
    """The prior before truncation: z(theta) is monotone and its cdf is Phi(z) (or uniform in z)."""

    prior: Prior

    def z(self, value: ArrayLike) -> FloatArray:
        theta: FloatArray = np.asarray(value, dtype=float)
        a, b = self.prior.a, self.prior.b
        with np.errstate(divide="ignore", invalid="ignore"):
            match self.prior.distribution:
                case "normal":
                    return (theta - a) / b
                case "lognormal":
                    return np.log(np.maximum(theta, 0.0) / a) / b
                case "halfnormal":
                    return np.asarray(theta) / a
                case "uniform":
                    return (theta - a) / (b - a)
                case "loguniform":
                    return np.log(np.maximum(theta, 0.0) / a) / np.log(b / a)
        raise ValueError(self.prior.distribution)

    def theta(self, z: FloatArray) -> FloatArray:
        a, b = self.prior.a, self.prior.b
        match self.prior.distribution:
            case "normal":
                return a + b * z
            case "lognormal":
                return a * np.exp(b * z)
            case "halfnormal":
                return a * z
            case "uniform":
                return a + (b - a) * z
            case "loguniform":
                return a * (b / a) ** z
        raise ValueError(self.prior.distribution)

    @property
    def gaussian(self) -> bool:
        return self.prior.distribution in ("normal", "lognormal", "halfnormal")

    def cdf(self, z: ArrayLike) -> FloatArray:
        return ndtr(z) if self.gaussian else np.clip(z, 0.0, 1.0)

    def quantile(self, p: FloatArray) -> FloatArray:
        return ndtri(p) if self.gaussian else p

    def log_density(self, theta: FloatArray) -> FloatArray:
        """Density in theta, up to the mass inside the bounds."""
        z = self.z(theta)
        a, b = self.prior.a, self.prior.b
        half = -0.5 * np.log(2 * np.pi)
        with np.errstate(divide="ignore", invalid="ignore"):
            match self.prior.distribution:
                case "normal":
                    return half - 0.5 * z**2 - np.log(b)
                case "lognormal":
                    return np.where(theta > 0, half - 0.5 * z**2 - np.log(b) - np.log(theta), -np.inf)
                case "halfnormal":
                    return np.where(theta >= 0, half - 0.5 * z**2 - np.log(a), -np.inf)
                case "uniform":
                    return np.where((z >= 0) & (z <= 1), -np.log(b - a), -np.inf)
                case "loguniform":
                    inside = (z >= 0) & (z <= 1)
                    return np.where(inside, -np.log(theta) - np.log(np.log(b / a)), -np.inf)
        raise ValueError(self.prior.distribution)


@dataclass(frozen=True)
class _Truncated:
    """One parameter's prior inside its bounds."""

    parameter: Parameter
    base: _Base
    low: float  # z of the bounds
    high: float
    mass: float
    direct: bool  # u = z: nothing is cut off

    @classmethod
    def of(cls, parameter: Parameter) -> _Truncated:
        _check(parameter)
        base = _Base(parameter.prior)
        lo, hi = parameter.bounds
        if parameter.prior.distribution == "halfnormal":
            lo = max(lo, 0.0)
        low, high = float(base.z(lo)), float(base.z(hi))
        if not base.gaussian:
            low, high = max(low, 0.0), min(high, 1.0)
        mass = float(base.cdf(high)) - float(base.cdf(low))
        if not mass > 1e-12:
            raise InputError(
                f"priors.{parameter.name}",
                f"the prior has no mass inside the bounds {lo:g} .. {hi:g}",
                "move the prior or its bounds",
            )
        direct = base.gaussian and low < 0 < high and 1 - mass < NEGLIGIBLE_MASS
        return cls(parameter, base, low, high, mass, direct)

    def from_normal(self, u: FloatArray) -> FloatArray:
        if self.direct:
            z = np.clip(u, self.low, self.high)
        else:
            u = np.clip(u, -FARTHEST, FARTHEST)
            if self.base.gaussian and self.low > 0:  # upper tail: work from above, where precision is
                p = ndtr(-self.high) + self.mass_above * ndtr(-u)
                z = -ndtri(p)
            else:
                z = self.base.quantile(float(self.base.cdf(self.low)) + self.mass * ndtr(u))
        return np.clip(self.base.theta(z), *self.parameter.bounds)

    @property
    def mass_above(self) -> float:
        return float(ndtr(-self.low) - ndtr(-self.high))

    def to_normal(self, theta: FloatArray) -> FloatArray:
        z = np.clip(self.base.z(np.asarray(theta, dtype=float)), self.low, self.high)
        if self.direct:
            return z
        if self.base.gaussian and self.low > 0:
            p = (ndtr(-z) - ndtr(-self.high)) / self.mass_above
            return np.clip(-ndtri(p), -FARTHEST, FARTHEST)
        p = (self.base.cdf(z) - float(self.base.cdf(self.low))) / self.mass
        return np.clip(ndtri(p), -FARTHEST, FARTHEST)

    def log_density(self, theta: FloatArray) -> FloatArray:
        lo, hi = self.parameter.bounds
        inside = (theta >= lo) & (theta <= hi)
        return np.where(inside, self.base.log_density(theta) - np.log(self.mass), -np.inf)


def _check(parameter: Parameter) -> None:
    """An impossible prior is an error that names the config's key."""
    where, p = f"priors.{parameter.name}", parameter.prior
    lo, hi = parameter.bounds
    if not lo < hi:
        raise InputError(where, f"bounds {lo:g} .. {hi:g} are empty", "give a low bound below the high one")
    if not (np.isfinite(p.a) and np.isfinite(p.b)):
        raise InputError(where, "the prior is not finite", "give finite numbers")
    ok = {
        "normal": p.b > 0,
        "lognormal": p.a > 0 and p.b > 0,
        "halfnormal": p.a > 0,
        "uniform": p.a < p.b,
        "loguniform": 0 < p.a < p.b,
    }
    if p.distribution not in ok:
        raise InputError(where, f"unknown distribution {p.distribution}", f"use one of {', '.join(ok)}")
    if not ok[p.distribution]:
        what = f"{p.distribution} prior with {p.a:g}, {p.b:g} is impossible"
        raise InputError(where, what, "spreads must be positive, medians positive, low below high")


@dataclass(frozen=True)
class Priors:
    """Independent priors of a parameter vector; the last axis of every array is the parameter."""

    parameters: tuple[Parameter, ...]
    _parts: tuple[_Truncated, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_parts", tuple(_Truncated.of(p) for p in self.parameters))

    @classmethod
    def of(cls, parameters: Sequence[Parameter]) -> Priors:
        return cls(tuple(parameters))

    def __len__(self) -> int:
        return len(self.parameters)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(p.name for p in self.parameters)

    @property
    def units(self) -> tuple[str, ...]:
        return tuple(p.unit for p in self.parameters)

    def from_normal(self, u: FloatArray) -> FloatArray:
        """Parameters (..., params) of standard normal coordinates u (..., params)."""
        u = np.asarray(u, dtype=float)
        return np.stack([part.from_normal(u[..., i]) for i, part in enumerate(self._parts)], axis=-1)

    def to_normal(self, theta: FloatArray) -> FloatArray:
        """Standard normal coordinates (..., params) of parameters theta; beyond the bounds: at the bound."""
        theta = np.asarray(theta, dtype=float)
        return np.stack([part.to_normal(theta[..., i]) for i, part in enumerate(self._parts)], axis=-1)

    def slope(self, u: FloatArray) -> FloatArray:
        """d theta / d u (..., params) by central differences of the map."""
        step = 1e-4
        return (self.from_normal(u + step) - self.from_normal(u - step)) / (2 * step)

    def log_density(self, theta: FloatArray) -> FloatArray:
        """Normalised log density (...,) of parameters (..., params); -inf outside the bounds."""
        theta = np.asarray(theta, dtype=float)
        return np.sum([part.log_density(theta[..., i]) for i, part in enumerate(self._parts)], axis=0)

    def sample(self, rng: np.random.Generator, draws: int) -> FloatArray:
        """Independent prior draws, (draws, params)."""
        return self.from_normal(rng.standard_normal((draws, len(self))))

    def sd(self) -> FloatArray:
        """Prior standard deviations (params,), by quadrature over u."""
        u = ndtri((np.arange(20000) + 0.5) / 20000)
        grid = self.from_normal(np.repeat(u[:, None], len(self), axis=1))
        return grid.std(axis=0)
