"""How often 90 % intervals hold what they should, on simulated campaigns of the base model without any effect.

    python benchmarks/posterior_coverage.py --campaigns 12

Each campaign has true parameters of its own, drawn from the priors (those of contact narrowed, or most clutches
would pull in or never touch); all four stages are sampled by short chains and every run is predicted with and
without its condition and its session in the fit. What is counted by campaign is pooled, with Clopper-Pearson
intervals for independent runs: runs of one campaign share its fit, so the spread over campaigns stands beside it.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
from measurement import record
from scipy.stats import beta

from eaclutch.cli.inference import capacity_data, measured_runs
from eaclutch.inference import storage
from eaclutch.inference.coverage import LEVELS
from eaclutch.inference.parameters import with_priors
from eaclutch.inference.posterior import StageInputs, run_stage, stage_problem
from eaclutch.inference.predict_campaign import curves_of, predict_campaign, ranks_of
from eaclutch.inference.priors import Priors
from eaclutch.inference.sampling import SamplerSettings
from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, Substrate
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.observables import SimulatedTable, simulate_table
from eaclutch.simulation.plan import Plan, sweep

BENCH = Bench(
    "coverage", substrates={"brass": Substrate(thickness={w * 1e-3: w * 1e-3 for w in (2, 2.5, 3)})}
)
SESSIONS = [date(2025, 3, day) for day in (3, 5, 7)]
REPEATS = 5
DRAWN = (
    "contact_stiffness", "roughness_sd", "kappa_static", "kappa_infinity", "relaxation_time", "cole_cole_exponent",
    "stiffness", "mass", "damping", "film_static", "film_kinetic", "base_static", "base_kinetic",
    "force_multiplier_level", "force_multiplier_slope",
)  # fmt: skip
NARROWED = {"contact_stiffness": 0.3, "roughness_sd": 0.08, "kappa_static": 0.08}  # sd of the logarithm
# Some thousand effective draws: enough for quantiles of 5 %, though not for the gate's R-hat.
CHAINS = SamplerSettings(
    ensembles=2, walkers=24, check_every=250, max_steps=250, stored_draws=250, warm_up=200
)
DRAWS = 100  # of each prediction
NINETY = int(np.flatnonzero(LEVELS == 0.9)[0])


def truth(known: Mapping[str, Any], rng: np.random.Generator) -> dict[str, float]:
    """True parameters of one clutch."""
    chosen = [known[name] for name in DRAWN]
    for i, parameter in enumerate(chosen):
        if parameter.name in NARROWED:
            chosen[i] = replace(parameter, prior=replace(parameter.prior, b=NARROWED[parameter.name]))
    return dict(zip(DRAWN, Priors.of(chosen).sample(rng, 1)[0].tolist(), strict=True))


def campaign(values: Mapping[str, float], rng: np.random.Generator) -> SimulatedTable:
    """60 runs: voltage, frequency, width and preload varied one at a time, in three sessions."""
    centre = {"voltage_v": 300.0, "frequency_hz": 1000.0, "width_mm": 2.0, "preload_n": 0.1}
    changes: list[dict[str, float]] = [
        {}, {"voltage_v": 200.0}, {"voltage_v": 250.0}, {"frequency_hz": 1.0}, {"frequency_hz": 10.0},
        {"frequency_hz": 100.0}, {"frequency_hz": 10000.0}, {"width_mm": 2.5}, {"width_mm": 3.0}, {"preload_n": 0.5},
        {"voltage_v": 250.0, "frequency_hz": 10.0}, {"voltage_v": 200.0, "width_mm": 3.0},
    ]  # fmt: skip
    runs = sweep([centre | change for change in changes], SESSIONS, REPEATS, rng)
    return simulate_table(Plan(runs), BENCH, BASE, values, BenchNoise(), rng)


def fitted(number: int, seed: int, folder: Path) -> dict[str, Any]:
    """One campaign: coverage of its runs by split and observable, and where the truth stands in the posterior."""
    rng = np.random.default_rng([seed, number])
    model = ClutchModel(BENCH, BASE, force_multiplier_form="linear")
    values = truth(model.parameters, rng)
    made = campaign(values, rng)
    inputs = StageInputs(
        BENCH, with_priors(model.parameters, {}), made.readings, made.spectra, bursts=made.bursts,
        capacity=capacity_data(made.runs, BENCH), model={"effects": list(BASE)},
    )  # fmt: skip
    files: list[Path] = []
    found: dict[str, Any] = {"effective": {}, "inside_90": {}, "seconds": time.process_time()}
    for stage in ("dielectric", "load_cell", "contact", "force"):
        path = folder / f"{number}_{stage}.nc"
        earlier = [f for f in files if stage in ("contact", "force")]
        problem = stage_problem(
            stage, replace(inputs, earlier=earlier), np.random.default_rng([seed, number, 7])
        )
        data, sampled = run_stage(problem, CHAINS, seed + number)
        storage.save(path, data)
        assert sampled is not None
        found["effective"][stage] = float(sampled.diagnostics.ess_tail.min())
        files.append(path)
        for name, draws in storage.load(path).draws.items():
            if name in values:  # of the force file's shared parameters the last word counts
                low, high = np.quantile(draws, [0.05, 0.95])
                found["inside_90"][name] = bool(low <= values[name] <= high)
    table = predict_campaign(
        model, replace(inputs, earlier=files), measured_runs(made.runs, BENCH), seed=seed + number, draws=DRAWS, parts=5
    )  # fmt: skip
    curves = curves_of(ranks_of([table]))
    found["curves"] = {
        split: {name: [curve["runs"], round(curve["covered"][NINETY] * curve["runs"])] for name, curve in rows.items()}
        for split, rows in curves.items()
    }  # fmt: skip
    found["seconds"] = time.process_time() - found["seconds"]
    return found


def pooled(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Coverage over campaigns by split and observable, and of true parameters."""
    splits: dict[str, Any] = {}
    for split in ("in_sample", "left_out_condition", "left_out_session"):
        rows = {}
        for name in results[0]["curves"][split]:
            counts = np.array([r["curves"][split][name] for r in results if name in r["curves"][split]])
            runs, inside = counts.sum(axis=0)
            shares = counts[:, 1] / counts[:, 0]
            rows[name] = {
                "runs": int(runs), "covered": inside / runs, "within_85_95": bool(0.85 <= inside / runs <= 0.95),
                "low": beta.ppf(0.05, inside, runs - inside + 1) if inside else 0.0,
                "high": beta.ppf(0.95, inside + 1, runs - inside) if inside < runs else 1.0,
                "campaigns_sd": float(shares.std(ddof=1)) if len(shares) > 1 else None,
            }  # fmt: skip
        splits[split] = rows
    names = sorted({name for r in results for name in r["inside_90"]})
    return {
        "predictions_90": splits,
        "parameters_90": {
            name: [sum(r["inside_90"].get(name, False) for r in results), len(results)] for name in names
        },
        "fewest_effective_draws": min(min(r["effective"].values()) for r in results),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    results: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(chosen.campaigns):
            results.append(fitted(number, chosen.seed, Path(folder)))
            share = results[-1]["curves"]["left_out_condition"]["all"]
            print(f"campaign {number}: {share[1]} of {share[0]}, {results[-1]['seconds']:.0f} s", flush=True)
            # each time: a long study may be cut short
            record(
                "posterior_coverage",
                f"python benchmarks/posterior_coverage.py --campaigns {len(results)} --seed {chosen.seed}",
                {"campaigns": len(results), "runs_a_campaign": 12 * REPEATS, **pooled(results)},
            )


if __name__ == "__main__":
    main()
