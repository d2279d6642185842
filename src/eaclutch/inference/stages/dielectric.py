"""Cole-Cole parameters from permittivity spectra of several sources.

A point i of source j is the model's kappa at that source's parameters plus noise of one absolute size (spectra are
read off linear axes). The sources' ln kappa_s, ln tau, alpha and ln kappa_inf scatter around the sought ones with sd
source_spread x (1, 2, 1, 5): spectra of nominally one polymer differ about twice as much in their relaxation time
as in their permittivity, and their high-frequency limit is barely seen. The scatter is marginalised source by source
(`source_levels`).
A single source shows no scatter: it is then taken as the film's own, and said so. Havriliak-Negami (exponent beta on
the denominator) is the same law with one more parameter; Cole-Cole is beta = 1.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem, digest
from eaclutch.inference.source_levels import LEVEL_SCALE, curve, marginal, source_modes
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.records import FloatArray, Spectrum

NAMES = ("kappa_static", "kappa_infinity", "relaxation_time", "cole_cole_exponent")

HAVRILIAK_NEGAMI = Parameter(
    "havriliak_negami_exponent", "1", (0.1, 3.0), 1.0, Prior("lognormal", 1.0, 0.3), 1.0,
    "exponent of the whole denominator; 1 is Cole-Cole",
)  # fmt: skip


def dielectric_problem(
    spectra: Sequence[Spectrum],
    parameters: Mapping[str, Parameter],
    *,
    weights: Mapping[str, float] | None = None,
    havriliak_negami: bool = False,
) -> Problem:
    """The dielectric stage. ``weights``: inverse variances of a source's points relative to the others', 0 leaves
    the source out; without usable spectra the posterior is the prior."""
    base = [parameters[name] for name in NAMES]
    weights = weights or {}
    notes = [f"{s.source} left out: weight 0" for s in spectra if weights.get(s.source, 1.0) == 0]
    usable = [s for s in spectra if len(s.frequency) and weights.get(s.source, 1.0) > 0]
    if not usable:
        return Problem("dielectric", Priors.of(base), notes=(*notes, "no permittivity spectra"))
    several = len(usable) > 1
    if not several:
        notes.append(
            "one source of permittivity: taken as the film's own, its spread to others cannot be seen"
        )
    log_omega = np.concatenate([np.log(2 * np.pi * s.frequency) for s in usable])
    data = np.concatenate([np.asarray(s.permittivity, dtype=float) for s in usable])
    counts = [len(s.frequency) for s in usable]
    starts = np.concatenate([[0], np.cumsum(counts)])
    weight = np.repeat([float(weights.get(s.source, 1.0)) for s in usable], counts)
    hyper = ["spectrum_noise", *(["source_spread"] if several else [])]
    extra = [HAVRILIAK_NEGAMI] if havriliak_negami else []
    priors = Priors.of([*base, *(parameters.get(n, HYPERPARAMETERS[n]) for n in hyper), *extra])

    def split(theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """kappa_s, kappa_inf, tau, alpha, beta (draws, 5), noise variances (draws, points), spreads (draws,)."""
        beta = theta[:, -1:] if havriliak_negami else np.ones((len(theta), 1))
        spread = theta[:, 5] if several else np.zeros(len(theta))
        return np.concatenate([theta[:, :4], beta], axis=1), theta[:, 4:5] ** 2 / weight, spread

    def log_likelihood(theta: FloatArray) -> FloatArray:
        return marginal(data, log_omega, starts, *split(theta))

    def pointwise(theta: FloatArray) -> FloatArray:
        result = np.empty((len(theta), len(data)))
        for draw, (shape, noise, spread) in enumerate(zip(*split(theta), strict=True)):
            modes = source_modes(data, log_omega, starts, shape, noise, spread)
            for j, (a, b) in enumerate(itertools.pairwise(starts)):
                mean, slope = curve(log_omega[a:b], shape, spread, modes[j])
                precision = np.linalg.inv(slope @ slope.T + np.diag(noise[a:b]))
                diagonal = np.diag(precision)
                gap = precision @ (data[a:b] - mean + slope @ modes[j]) / diagonal
                result[draw, a:b] = 0.5 * np.log(diagonal / (2 * np.pi)) - 0.5 * diagonal * gap**2
        return result

    def predictive(theta: FloatArray, rng: np.random.Generator, posterior: bool = True) -> FloatArray:
        result = np.empty((len(theta), len(data)))
        for draw, (shape, noise, spread) in enumerate(zip(*split(theta), strict=True)):
            for a, b in itertools.pairwise(starts):
                level = rng.standard_normal(len(LEVEL_SCALE))
                mean, _ = curve(log_omega[a:b], shape, spread, level)
                result[draw, a:b] = mean + np.sqrt(noise[a:b]) * rng.standard_normal(b - a)
        return result

    return Problem(
        "dielectric", priors, log_likelihood, pointwise, predictive, data,
        data_name="relative_permittivity", data_unit="1",
        coords={"frequency": np.exp(log_omega) / (2 * np.pi), "source": np.repeat([s.source for s in usable], counts)},
        notes=tuple(notes),
        wider=None if havriliak_negami else dielectric_problem(
            spectra, parameters, weights=weights, havriliak_negami=True
        ),
        fingerprint={"data": digest([data, log_omega, starts, weight]),
                     "model": digest([havriliak_negami, LEVEL_SCALE])},
    )  # fmt: skip
