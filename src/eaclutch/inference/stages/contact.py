"""Contact stiffness and roughness from raw force-capacitance readings.

A reading i of trial t and width w is ln C_i = ln(B_w / g_i + C_stray) + s_i (o + a_w(F_i) + b_t(F_i)) + noise,
with the electrical gap g = T_d / kappa + h, h = sigma G^-1(F / (k L w sigma^1.5)) (Greenwood-Williamson), and
s = d ln C / d g. The shared offset o (film thickness and permittivity), the widths' and the trials' gap
curves a and b are Gaussian and enter to first order, so they are marginalised exactly (C is so
nearly linear in a gap change of a tenth of a micrometre that the second order is below the noise).
a and b are curves over ln F, half constant and half smooth with a correlation length of one e-fold: what the
contact law does not describe is shared by neighbouring readings, and counting it as independent noise would
make k and sigma several times too certain. The force's own error enters through the slope of the readings
themselves, so that no contact law makes it small: with the law's own slope, a force error that is stated too large
drew sigma to where that slope vanishes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from eaclutch.inference import gaussian_levels
from eaclutch.inference.gaussian_levels import LevelDesign, Levels
from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem, digest
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.physics.laws import capacitance_scale, greenwood_williamson
from eaclutch.records import Bench, CapacitanceReadings, FloatArray, InputError

CONSTANT_SHARE = 0.5  # of a level's variance; the rest is smooth in ln F
LEAST_RANGE = 0.5  # e-folds of the force over which a slope shows
CORRELATION = 1.0  # length of the smooth part, in e-folds of the force


@dataclass(frozen=True)
class ContactSettings:
    """What the fit uses.

    force_sd [N]: standard uncertainty of a force reading, those below twice it are left out; force_max [N] or None;
    widths [m]: those to use, empty for all (a width that no substrate of the bench has is left out in any case);
    stray_sd [F]: prior of the stray capacitance around the fixture's, 0 = known.
    """

    force_sd: float = 0.01
    force_max: float | None = None
    widths: tuple[float, ...] = ()
    stray_sd: float = 0.0


@dataclass(frozen=True)
class FilmOffset:
    """Gaussian belief about T_d / kappa [m] at the meter's frequency, and T_d [m] given it:
    T_d = thickness + slope (offset - mean), residual sd."""

    mean: float
    sd: float
    thickness: float
    slope: float
    residual_sd: float

    @classmethod
    def of(cls, thickness: FloatArray, kappa: FloatArray) -> FilmOffset:
        """From draws (draws,) of the film thickness [m] and of kappa at the meter's frequency."""
        offset = thickness / kappa
        variance = float(np.var(offset))
        slope = (
            float(np.mean((offset - offset.mean()) * (thickness - thickness.mean())) / variance)
            if variance
            else 0.0
        )
        rest = thickness - thickness.mean() - slope * (offset - offset.mean())
        return cls(float(offset.mean()), variance**0.5, float(thickness.mean()), slope, float(np.std(rest)))


class InverseContact:
    """x = h / sigma from ln G(x), tabulated once over x in [-12, 18]."""

    def __init__(self) -> None:
        x = np.linspace(-12.0, 18.0, 961)
        fine = np.linspace(x[0], x[-1], 20_001)
        self.log_g = CubicSpline(x, np.log(greenwood_williamson(x)))(fine)[::-1].copy()
        self.x = fine[::-1].copy()

    def __call__(self, log_g: FloatArray) -> FloatArray:
        return np.interp(log_g, self.log_g, self.x)


def select(
    readings: CapacitanceReadings, bench: Bench, settings: ContactSettings
) -> tuple[np.ndarray, list[str]]:
    """Mask (readings,) of what the fit uses, and a note for all that is left out."""
    force = readings.force
    keep = np.isfinite(force) & np.isfinite(readings.capacitance) & (readings.capacitance > 0)
    notes = []
    below = keep & (force < 2 * settings.force_sd)
    if below.any():
        notes.append(
            f"{below.sum()} readings below {2 * settings.force_sd:g} N left out: the force's own error"
        )
    keep &= ~below
    if settings.force_max is not None:
        above = keep & (force > settings.force_max)
        if above.any():
            notes.append(f"{above.sum()} readings above {settings.force_max:g} N left out by config")
        keep &= ~above
    listed = sorted({w for substrate in bench.substrates.values() for w in substrate.thickness})
    for chosen, reason in (
        (settings.widths, "not chosen by config"),
        (listed, "no substrate of this bench has it"),
    ):
        if len(chosen):
            other = keep & ~np.any(np.isclose(readings.width[:, None], chosen, rtol=1e-3), axis=1)
            for width in np.unique(readings.width[other]):
                notes.append(
                    f"{np.sum(readings.width[other] == width)} readings at {width * 1e3:g} mm left out: {reason}"
                )
            keep &= ~other
    return keep, notes


def contact_problem(
    readings: CapacitanceReadings | None,
    bench: Bench,
    parameters: Mapping[str, Parameter],
    film: FilmOffset,
    settings: ContactSettings = ContactSettings(),
) -> Problem:
    """The contact stage. ``parameters`` holds contact_stiffness and roughness_sd (model) with their priors.

    Without usable readings the posterior is the prior. Raises InputError for a stray capacitance that
    exceeds the readings.
    """
    named = [parameters["contact_stiffness"], parameters["roughness_sd"]]
    stray0 = bench.fixture.stray_capacitance
    keep, notes = (np.zeros(0, bool), []) if readings is None else select(readings, bench, settings)
    units = {"stray_capacitance": "F", "film_thickness": "m", "film_offset": "m"}

    def film_draws(offset: FloatArray, rng: np.random.Generator) -> dict[str, FloatArray]:
        thickness = film.thickness + film.slope * (offset - film.mean)
        thickness = thickness + film.residual_sd * rng.standard_normal(len(offset))
        return {"film_offset": offset, "film_thickness": thickness}

    if readings is None or not keep.any():

        def prior_only(theta: FloatArray, rng: np.random.Generator) -> dict[str, FloatArray]:
            n = len(theta)
            stray = stray0 + settings.stray_sd * rng.standard_normal(n)
            return {"stray_capacitance": stray} | film_draws(
                film.mean + film.sd * rng.standard_normal(n), rng
            )

        return Problem(
            "contact", Priors.of(named), derived=prior_only, derived_units=units,
            notes=(*notes, "no usable capacitance readings"),
        )  # fmt: skip
    force, width = readings.force[keep], readings.width[keep]
    capacitance = readings.capacitance[keep]
    trial = np.array(readings.trial)[keep]
    source = np.array(readings.source)[keep]
    sampled_stray = settings.stray_sd > 0
    if np.min(capacitance) <= stray0:
        raise InputError(
            "campaign.yaml, capacitance_fixture.stray_capacitance_pf",
            f"{stray0 * 1e12:g} pF is more than the smallest reading",
            "give the stray capacitance that the readings still contain",
        )
    if len(np.unique(width)) == 1:
        notes.append("one width only: its spread to other widths rests on the prior")
    if len(force) < 4:
        notes.append(f"only {len(force)} readings: expect the prior")
    names = ["capacitance_noise", "trial_spread", "width_spread"]
    if sampled_stray:
        named = [*named, stray_parameter(stray0, settings.stray_sd)]
    labels = np.array([f"{s}\x00{t}\x00{w}" for s, t, w in zip(source, trial, width, strict=True)])
    design = LevelDesign.of(np.log(force), width, labels, CONSTANT_SHARE, CORRELATION)
    scale = capacitance_scale(bench.pad, width, bench.fixture.overlap_length)
    inverse, log_force = InverseContact(), np.log(force)
    force_error = _slope(log_force, data := np.log(capacitance), width) * settings.force_sd / force
    length = bench.fixture.overlap_length
    head = len(named)

    def terms(theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mean of ln C, d ln C / d gap and noise variance, each (draws, readings)."""
        k, sigma = theta[:, 0, None], theta[:, 1, None]
        stray = theta[:, 2, None] if sampled_stray else stray0
        x = inverse(log_force - np.log(k * length * width * sigma**1.5))
        gap = film.mean + np.maximum(sigma * x, -0.99 * film.mean)
        pad_capacitance = scale / gap
        with np.errstate(invalid="ignore"):
            mean = np.log(pad_capacitance + stray)
        sensitivity = -pad_capacitance / gap / (pad_capacitance + stray)
        return mean, sensitivity, theta[:, head, None] ** 2 + force_error**2

    def residuals(theta: FloatArray) -> tuple[FloatArray, FloatArray, Levels]:
        mean, sensitivity, noise = terms(theta)
        return mean, data - mean, Levels(sensitivity, noise, theta[:, head + 2], theta[:, head + 1], film.sd)

    def log_likelihood(theta: FloatArray) -> FloatArray:
        _, residual, levels = residuals(theta)
        return gaussian_levels.marginal(residual, levels, design)[0]

    def pointwise(theta: FloatArray) -> FloatArray:
        _, residual, levels = residuals(theta)
        return gaussian_levels.pointwise(residual, levels, design)

    def predictive(theta: FloatArray, rng: np.random.Generator, posterior: bool = True) -> FloatArray:
        mean, _, levels = residuals(theta)
        return mean + gaussian_levels.replicate(levels, design, rng)

    def derived(theta: FloatArray, rng: np.random.Generator) -> dict[str, FloatArray]:
        _, residual, levels = residuals(theta)
        _, offset, variance = gaussian_levels.marginal(residual, levels, design)
        drawn = film.mean + offset + np.sqrt(variance) * rng.standard_normal(len(theta))
        found = film_draws(drawn, rng)
        if not sampled_stray:
            found["stray_capacitance"] = np.full(len(theta), stray0)
        return found

    priors = Priors.of([*named, *(_own(parameters, name) for name in names)])
    return Problem(
        "contact", priors, log_likelihood, pointwise, predictive, data,
        data_name="log_capacitance", data_unit="ln F",
        coords={"force": force, "width": width, "trial": trial, "source": source},
        derived=derived, derived_units=units, notes=tuple(notes),
        fingerprint={"data": digest([force, capacitance, width, list(labels)]),
                     "model": digest([film.mean, film.sd, stray0, length, settings.force_sd, repr(bench.pad)])},
    )  # fmt: skip


def _slope(log_force: FloatArray, log_capacitance: FloatArray, width: FloatArray) -> FloatArray:
    """d ln C / d ln F (readings,) of a parabola through all readings, each width on a level of its own; 1, which no
    contact reaches, where the forces are too much alike to show a slope."""
    x = log_force - log_force.mean()
    if np.ptp(x) < LEAST_RANGE:
        return np.ones_like(x)
    levels = width[:, None] == np.unique(width)
    found = np.linalg.lstsq(np.column_stack([levels, x, x**2]), log_capacitance)[0]
    return np.asarray(found[-2] + 2.0 * found[-1] * x)


def stray_parameter(mean: float, sd: float) -> Parameter:
    """Prior of the stray capacitance [F] around the fixture's."""

    return Parameter(
        "stray_capacitance", "F", (mean - 10 * sd, mean + 10 * sd), mean, Prior("normal", mean, sd)
    )


def _own(parameters: Mapping[str, Parameter], name: str) -> Parameter:
    return parameters.get(name, HYPERPARAMETERS[name])
