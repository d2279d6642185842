"""Mass and damping of the load cell from the free swings of the bare cell; its stiffness keeps its prior.

f = sqrt(k / m) sqrt(1 - zeta^2) / (2 pi) and zeta = b / (2 sqrt(k m)) of every burst, with their own errors and a
spread between bursts. The bursts hold no force step, so k comes from the prior and m follows it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem, digest
from eaclutch.physics.effect import Parameter
from eaclutch.records import BurstFeatures, FloatArray


def swing(stiffness: FloatArray, mass: FloatArray, damping: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frequency [Hz] of the damped swing and damping ratio; an overdamped cell has frequency 0."""
    ratio = damping / (2 * np.sqrt(stiffness * mass))
    frequency = np.sqrt(stiffness / mass) * np.sqrt(np.maximum(1 - ratio**2, 0.0)) / (2 * np.pi)
    return frequency, ratio


def load_cell_problem(bursts: BurstFeatures | None, parameters: Mapping[str, Parameter]) -> Problem:
    """The load-cell stage. ``parameters`` holds stiffness, mass and damping with their priors."""
    base = [parameters[name] for name in ("stiffness", "mass", "damping")]
    if bursts is None or not len(bursts.frequency):
        return Problem("load_cell", Priors.of(base), notes=("no step responses of the bare load cell",))
    count = len(bursts.frequency)
    data = np.concatenate([bursts.frequency, bursts.damping_ratio])
    own = np.concatenate([bursts.frequency_sd, bursts.damping_ratio_sd]) ** 2
    hyper = ("frequency_spread", "damping_spread")
    priors = Priors.of([*base, *(parameters.get(name, HYPERPARAMETERS[name]) for name in hyper)])

    def moments(theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean and variance (draws, 2 x bursts) of frequencies and damping ratios."""
        frequency, ratio = swing(theta[:, 0], theta[:, 1], theta[:, 2])
        mean = np.repeat(np.stack([frequency, ratio], axis=1), count, axis=1)
        spread = np.repeat(theta[:, 3:5], count, axis=1)
        return mean, own + (spread * mean) ** 2 + 1e-30

    def pointwise(theta: FloatArray) -> FloatArray:
        mean, variance = moments(theta)
        return -0.5 * ((data - mean) ** 2 / variance + np.log(2 * np.pi * variance))

    def predictive(theta: FloatArray, rng: np.random.Generator, posterior: bool = True) -> FloatArray:
        mean, variance = moments(theta)
        return mean + np.sqrt(variance) * rng.standard_normal(mean.shape)

    return Problem(
        "load_cell", priors, lambda theta: np.sum(pointwise(theta), axis=1), pointwise, predictive, data,
        data_name="swing", data_unit="Hz, then 1",
        coords={"quantity": np.repeat(["frequency_hz", "damping_ratio"], count)},
        notes=("the stiffness rests on its prior: the bursts hold no force step",),
        fingerprint={"data": digest([data, own]), "model": digest("swing")},
    )  # fmt: skip
