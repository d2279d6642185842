"""Posteriors as ArviZ InferenceData files: the only module that imports arviz.

chain = ensemble; draw = (step, walker) of that ensemble, thinned in steps. ArviZ's own R-hat and ESS on these
files look at interleaved walkers and flatter; the file's attributes and summary.json hold those of
`convergence`.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

with warnings.catch_warnings():
    warnings.simplefilter("ignore", FutureWarning)  # 0.23 announces 1.x, which has no InferenceData
    import arviz

from eaclutch.files import atomic
from eaclutch.inference.problem import Problem
from eaclutch.inference.sampling import Sampled, SamplerSettings
from eaclutch.records import FloatArray, InputError


@dataclass(frozen=True)
class StoredPosterior:
    """What later stages read: draws {name: (chains x draws,)}, units, source, converged, attributes."""

    draws: Mapping[str, FloatArray]
    units: Mapping[str, str]
    prior_sd: Mapping[str, float]
    source: str
    converged: bool | None
    attributes: Mapping[str, Any]


def thin(chain: FloatArray, draws: int) -> FloatArray:
    """(ensembles, steps, walkers, ...) to (ensembles, <= draws, ...): whole steps, evenly spaced."""
    ensembles, steps, walkers = chain.shape[:3]
    count = max(min(draws // walkers, steps), 1)
    rows = np.linspace(0, steps - 1, count).round().astype(int)
    return chain[:, rows].reshape(ensembles, count * walkers, *chain.shape[3:])


def inference_data(
    problem: Problem, settings: SamplerSettings, seed: int, sampled: Sampled | None
) -> arviz.InferenceData:
    """All groups of a stage's file; ``sampled`` None: the stage rests on its prior."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 1]))
    priors = problem.priors
    if sampled is None:
        theta = priors.sample(rng, settings.ensembles * settings.stored_draws)
        theta = theta.reshape(settings.ensembles, settings.stored_draws, len(priors))
        density = priors.log_density(theta)
    else:
        theta = thin(sampled.chain, settings.stored_draws)
        density = thin(sampled.log_density, settings.stored_draws)
    shape = theta.shape[:2]
    flat = theta.reshape(-1, len(priors))
    prior_flat = priors.sample(rng, settings.ensembles * settings.stored_draws)
    prior_shape = (settings.ensembles, settings.stored_draws)
    groups: dict[str, dict[str, FloatArray]] = {
        "posterior": _variables(problem, flat, shape, rng),
        "prior": {n: prior_flat[:, i].reshape(prior_shape) for i, n in enumerate(priors.names)},
        "sample_stats": {"lp": density},
    }
    dims: dict[str, list[str]] = {}
    coords: dict[str, object] = {}
    if problem.has_data:
        assert problem.predictive and problem.pointwise and problem.observed is not None
        name, points = problem.data_name, len(problem.observed)
        dims = {name: ["point"]}
        coords = {"point": np.arange(points)}
        few = prior_flat[:: max(settings.ensembles, 1)]
        groups["posterior_predictive"] = {name: problem.predictive(flat, rng).reshape(*shape, points)}
        groups["prior_predictive"] = {
            name: problem.predictive(few, rng, posterior=False).reshape(1, len(few), points)
        }
        groups["log_likelihood"] = {name: problem.pointwise(flat).reshape(*shape, points)}
        groups["observed_data"] = {name: problem.observed}
        groups["constant_data"] = {key: np.asarray(value) for key, value in problem.coords.items()}
        dims |= {key: ["point"] for key in problem.coords}
    data = arviz.from_dict(
        **groups,  # type: ignore[arg-type]
        dims=dims,
        coords=coords,
        attrs=_attributes(problem, sampled),
        save_warmup=False,
    )
    units = {p.name: p.unit for p in priors.parameters} | dict(problem.derived_units)
    for group in ("posterior", "prior"):
        for name, variable in data[group].data_vars.items():
            variable.attrs["unit"] = units.get(str(name), "1")
    if problem.has_data:
        for group in ("posterior_predictive", "prior_predictive", "observed_data"):
            data[group][problem.data_name].attrs["unit"] = problem.data_unit
    return data


def _variables(
    problem: Problem, flat: FloatArray, shape: tuple[int, ...], rng: np.random.Generator
) -> dict[str, FloatArray]:
    found = {name: flat[:, i].reshape(shape) for i, name in enumerate(problem.priors.names)}
    if problem.derived is not None:
        found |= {name: np.reshape(values, shape) for name, values in problem.derived(flat, rng).items()}
    return found


def _attributes(problem: Problem, sampled: Sampled | None) -> dict[str, object]:
    attributes: dict[str, object] = {
        "stage": problem.stage,
        "source": "data" if sampled is not None else "prior",
        "notes": "; ".join(problem.notes),
        "fingerprint": json.dumps(problem.fingerprints(), sort_keys=True),
        "prior_sd": json.dumps(dict(zip(problem.priors.names, problem.priors.sd().tolist(), strict=True))),
        "converged": "null",
    }
    if sampled is not None:
        found = sampled.diagnostics
        attributes |= {
            "converged": "true" if sampled.converged else "false",
            "failures": "; ".join(sampled.failures),
            "steps": sampled.total_steps,
            "names": json.dumps(list(problem.priors.names)),
            "r_hat": found.r_hat,
            "ess_bulk": found.ess_bulk,
            "ess_tail": found.ess_tail,
            "autocorrelation_time": found.tau,
            "log_likelihood_means": "log density of each datum given all other data and the parameters",
        }
    return attributes


def save(path: Path, data: arviz.InferenceData) -> None:
    """Write netCDF atomically; equal content gives equal bytes but for ArviZ's creation time."""
    with atomic(path) as temporary:
        temporary.unlink()
        data.to_netcdf(str(temporary), engine="h5netcdf")


def read(path: Path) -> arviz.InferenceData:
    """Open a stage's file; raises InputError where it is none."""
    try:
        return arviz.from_netcdf(str(path), engine="h5netcdf")
    except (OSError, ValueError, KeyError) as error:
        raise InputError(path, "is not a posterior file", "run the stage's posterior rule again") from error


def load(path: Path) -> StoredPosterior:
    """A stage's draws and what is known about them."""
    data = read(path)
    attributes = dict(data.attrs or data["posterior"].attrs)
    group = data["posterior"]
    draws = {str(name): np.asarray(values).reshape(-1) for name, values in group.data_vars.items()}
    units = {str(name): str(values.attrs.get("unit", "1")) for name, values in group.data_vars.items()}
    converged = {"true": True, "false": False}.get(str(attributes["converged"]))
    prior_sd = json.loads(str(attributes["prior_sd"]))
    return StoredPosterior(draws, units, prior_sd, str(attributes["source"]), converged, attributes)
