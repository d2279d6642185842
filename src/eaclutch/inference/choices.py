"""A table: how much k, sigma, kappa_s, tau, alpha and lambda move when each choice of the published fits changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.inference.posterior import capacity_function
from eaclutch.inference.problem import Problem
from eaclutch.inference.published_fits import contact_fit, dielectric_fit, multiplier_fit
from eaclutch.inference.stages.contact import ContactSettings, select
from eaclutch.inference.stages.force import CapacityData
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, CapacitanceReadings, FloatArray, Spectrum

AUTHORS_WEIGHTS = {"wang_2009": 5.0, "tang_2012": 8.0, "vendor_datasheet": 101.0}
# name: film [m], kappa, largest force [N]; published k and sigma where the paper has them
CONTACT_CHOICES: Mapping[str, tuple[float, float, float, float | None, float | None]] = {
    "film 28 um, kappa 45, force <= 4 N (the authors')": (28e-6, 45.0, 4.0, 5.39e14, 2.80e-6),
    "force <= 8 N": (28e-6, 45.0, 8.0, None, None),
    "film 24 um, kappa 53.2, force <= 4 N (the paper's text)": (24e-6, 53.2, 4.0, None, None),
    "film 24 um, kappa 53.2, force <= 8 N": (24e-6, 53.2, 8.0, None, None),
}
COLUMNS = ("quantity", "unit", "choice", "value", "published", "fit_q05", "fit_q95", "inside")
GRID = np.exp(np.linspace(np.log(0.05), np.log(20.0), 60))


@dataclass(frozen=True)
class Replicates:
    """Data replicated from a stage's posterior, (draws, points), in the problem's own unit and order."""

    problem: Problem
    theta: FloatArray

    def draw(self, rng: np.random.Generator) -> FloatArray:
        assert self.problem.predictive is not None
        return self.problem.predictive(self.theta, rng)


def contact_rows(
    readings: CapacitanceReadings, bench: Bench, replicates: Replicates | None, rng: np.random.Generator
) -> list[dict[str, Any]]:
    """Fits of the readings by every choice, with the spread of the same fit over the posterior's replicates."""
    keep, _ = select(readings, bench, ContactSettings())
    used = _part(readings, keep)
    made = (
        [] if replicates is None else [replace(used, capacitance=np.exp(row)) for row in replicates.draw(rng)]
    )
    # below twice the force's error readings stay in the fits as the authors have them
    widths = np.unique(used.width)
    whole = _part(readings, np.isin(readings.width, widths) & (readings.force >= 0))
    rows = []
    for choice, (film, kappa, force_max, k, sigma) in CONTACT_CHOICES.items():
        value = contact_fit(whole, bench, film=film, kappa=kappa, force_max=force_max)
        fits = np.array(
            [contact_fit(part, bench, film=film, kappa=kappa, force_max=force_max) for part in made]
        )
        rows.append(
            _row("contact_stiffness", "N m^-3.5", choice, value[0], k, fits[:, 0] if len(fits) else None)
        )
        rows.append(_row("roughness_sd", "m", choice, value[1], sigma, fits[:, 1] if len(fits) else None))
    return rows


def dielectric_rows(
    spectra: Sequence[Spectrum], replicates: Replicates | None, rng: np.random.Generator
) -> list[dict[str, Any]]:
    """Fits of the spectra with the authors' weights, without weights, and of each source alone."""
    made = []
    if replicates is not None:
        edges = np.cumsum([len(s.frequency) for s in spectra])[:-1]
        for row in replicates.draw(rng):
            parts = np.split(row, edges)
            made.append([replace(s, permittivity=part) for s, part in zip(spectra, parts, strict=True)])
    names = [s.source for s in spectra]
    choices: dict[str, tuple[Mapping[str, float], tuple[float | None, ...]]] = {
        "weights Wang 5, Tang 8, vendor 101 (the authors')": (AUTHORS_WEIGHTS, (54.2, 2.82e-6, 0.562)),
        "no weights": ({}, (None, None, None)),
    }
    choices |= {f"{name} alone": ({n: float(n == name) for n in names}, (None, None, None)) for name in names}
    rows = []
    for choice, (weights, published) in choices.items():
        value = dielectric_fit(spectra, weights)
        fits = np.array([dielectric_fit(part, weights) for part in made])
        for i, (name, unit) in enumerate(
            (("kappa_static", "1"), ("relaxation_time", "s"), ("cole_cole_exponent", "1"))
        ):
            rows.append(_row(name, unit, choice, value[i], published[i], fits[:, i] if len(fits) else None))
    return rows


def multiplier_rows(
    model: ClutchModel,
    data: CapacityData,
    choices: Mapping[str, Mapping[str, float]],
    form_draws: Mapping[str, FloatArray],
) -> list[dict[str, Any]]:
    """lambda_ea's slope, intercept and mean for point values of the others (``choices``), and of our posterior.

    ``model`` has the form ``constant``; ``form_draws``: draws of force_multiplier_level and _slope.
    """
    capacity = capacity_function(model, data.conditions)
    rows = []
    published = {"slope": -0.0058, "intercept": 2.40, "mean": 1.08}
    units = {"slope": "1/V", "intercept": "1", "mean": "1"}
    for choice, values in choices.items():
        nuisances = {name: np.array([value]) for name, value in values.items()}
        log_capacity = np.log(np.stack([capacity(nuisances, float(x))[0] for x in GRID]))
        fit = multiplier_fit(log_capacity, data.capacity, data.conditions.voltage, GRID)
        rows += [
            _row(f"force_multiplier_{part}", units[part], choice, value, published[part], None)
            for part, value in zip(("slope", "intercept", "mean"), fit, strict=True)
        ]
    if "force_multiplier_slope" in form_draws:
        slope, level = form_draws["force_multiplier_slope"], form_draws["force_multiplier_level"]
        own = {"slope": slope, "intercept": level - 200.0 * slope,
               "mean": level + slope * (np.mean(data.conditions.voltage) - 200.0)}  # fmt: skip
        rows += [
            _row(
                f"force_multiplier_{part}",
                units[part],
                "our posterior",
                float(np.mean(draws)),
                published[part],
                draws,
            )
            for part, draws in own.items()
        ]
    return rows


def table(rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """The rows as published_fits.csv has them."""
    return pd.DataFrame(list(rows), columns=list(COLUMNS))


def _part(readings: CapacitanceReadings, keep: np.ndarray) -> CapacitanceReadings:
    rows = np.flatnonzero(keep)
    return CapacitanceReadings(
        readings.force[rows], readings.capacitance[rows], readings.width[rows],
        tuple(readings.trial[i] for i in rows), tuple(readings.source[i] for i in rows),
    )  # fmt: skip


def _row(
    quantity: str, unit: str, choice: str, value: float, published: float | None, fits: FloatArray | None
) -> dict[str, Any]:
    low, high = (np.nan, np.nan) if fits is None else np.quantile(fits, [0.05, 0.95])
    reference = value if published is None else published
    inside = None if fits is None else bool(low <= reference <= high)
    return {
        "quantity": quantity, "unit": unit, "choice": choice, "value": value, "published": published,
        "fit_q05": low, "fit_q95": high, "inside": inside,
    }  # fmt: skip
