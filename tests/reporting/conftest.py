"""A results folder with hand-made numbers, so that the page is tested without a campaign."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from eaclutch.files import atomic, write_csv, write_json

PARAMETERS = {
    "contact": {"contact_stiffness": (5e14, "N m^-3.5"), "roughness_sd": (2.7e-6, "m")},
    "dielectric": {"kappa_static": (54.0, "1")},
    "load_cell": {"stiffness": (18018.0, "N/m"), "mass": (1.1e-3, "kg")},
    "force": {"force_multiplier_level": (1.1, "1")},
}
OBSERVABLES = {"shear_capacity_n": "N", "release_time_90_s": "s"}
FREQUENCIES = (0.1, 10.0, 1000.0)


@pytest.fixture
def results_folder(tmp_path: Path) -> Path:
    rng = np.random.default_rng(3)
    folder = tmp_path / "results" / "bench-7"
    runs = [f"run_{i:02d}" for i in range(12)]
    table = pd.DataFrame({"run": runs})
    table["session"] = ["a" if i % 2 else "b" for i in range(12)]
    table["condition"] = [f"c{i % 3}" for i in range(12)]
    table["voltage_v"], table["width_mm"], table["preload_n"] = 300.0, 2.0, 0.1
    table["frequency_hz"] = [FREQUENCIES[i % 3] for i in range(12)]
    table["shear_capacity_n"], table["shear_capacity_n_sd"] = rng.normal(1.5, 0.05, 12), 0.01
    table["release_time_90_s"], table["release_time_90_s_sd"] = rng.normal(1.1e-3, 5e-5, 12), 2e-5
    table["usable"] = [i != 4 for i in range(12)]
    table["flags"] = ["no_voltage" if i == 4 else "" for i in range(12)]
    table["reasons"] = [
        "shear_capacity_n:no_voltage;release_time_90_s:no_voltage" if i == 4 else "" for i in range(12)
    ]
    write_csv(folder / "runs.csv", table)
    files = [{"path": f"tensile/{run}.csv", "bytes": 1, "sha256": "0" * 64} for run in runs]
    write_json(folder / "capture.json", {"campaign": "bench-7", "batches": [0], "files": files, "runs": []})
    write_json(
        folder / "observables.json",
        [
            {"name": n, "unit": u, "phase": "ramp", "definition": n, "resolution": None}
            for n, u in OBSERVABLES.items()
        ],
    )
    write_json(
        folder / "quality.json", {"runs": 12, "usable": 11, "flags": {}, "unusable": {}, "excluded": {}}
    )
    for name in ("gap.csv", "spectra.csv", "bursts.csv"):
        (folder / name).write_text("a,b\n")
    with atomic(folder / "observables" / "traces_0.npz") as path, path.open("wb") as stream:
        time = np.linspace(-1, 3, 50)
        trace = np.column_stack([time, np.clip(time, 0, 1), (time > 0) & (time < 2)])
        np.savez_compressed(stream, **dict.fromkeys(runs, trace))
    _posteriors(folder, rng)
    predicted = [
        {
            "run": row.run,
            "observable": name,
            "q05": 0.9 * value,
            "median": value,
            "q95": 1.1 * value,
            "measured": getattr(row, name),
            "measured_sd": 0.01 * value,
            "status": "ok",
            "held_out": True,
        }
        for row in table.itertuples()
        for name, value in (("shear_capacity_n", 1.5), ("release_time_90_s", 1.0e-3))
    ]
    write_csv(folder / "predict" / "runs.csv", pd.DataFrame(predicted))
    write_json(folder / "predict" / "coverage.json", {})
    write_json(folder / "diagnosis" / "diagnosis.json", named())
    return folder


def _posteriors(folder: Path, rng: np.random.Generator) -> None:
    summary: dict[str, dict] = {}
    for stage, parameters in PARAMETERS.items():
        draws = {
            name: (("chain", "draw"), rng.normal(value, 0.1 * value, (4, 100)))
            for name, (value, _) in parameters.items()
        }
        posterior, prior = xr.Dataset(draws), xr.Dataset(draws)
        for name, (_, unit) in parameters.items():
            posterior[name].attrs["unit"] = unit
        (folder / "posterior").mkdir(exist_ok=True)
        tree = xr.DataTree.from_dict({"posterior": posterior, "prior": prior})
        tree.to_netcdf(folder / "posterior" / f"{stage}.nc", engine="h5netcdf")
        entries = {
            name: {
                "mean": v,
                "sd": 0.1 * v,
                "q05": 0.8 * v,
                "median": v,
                "q95": 1.2 * v,
                "r_hat": 1.002,
                "ess_bulk": 900,
                "ess_tail": 800,
                "unit": unit,
                "prior_sd": v,
            }
            for name, (v, unit) in parameters.items()
        }
        summary[stage] = {"converged": True, "source": "data", "parameters": entries}
    summary["dielectric"] |= {"converged": None, "source": "prior"}
    summary["force"] |= {"converged": False}
    write_json(folder / "posterior" / "summary.json", summary)


def named() -> dict:
    """A diagnosis that names an effect."""
    return {
        "gap": {
            "total": {"before": 3.1, "after": 1.27, "noise_floor": 1.05, "interval": [2.6, 3.7]},
            "by_observable": {
                "release_time_90_s": {
                    "before": 1.9e-4,
                    "after": 5e-5,
                    "noise_floor": 2e-5,
                    "interval": [1.6e-4, 2.3e-4],
                    "unit": "s",
                    "p_value": 0.001,
                },
                "shear_capacity_n": {
                    "before": 0.0,
                    "after": 0.0,
                    "noise_floor": 0.0,
                    "interval": [0, 0],
                    "unit": "N",
                    "p_value": 0.7,
                },
            },
        },
        "where": [
            {
                "observable": "release_time_90_s",
                "factor": "frequency_hz",
                "level": "<=10",
                "phase": "release",
                "share": 0.61,
                "interval": [0.5, 0.7],
                "direction": "+",
                "p_value": 0.001,
                "confounded_with": ["session"],
            },
        ],
        "hypotheses": [
            {"effects": ["trapped_charge"], "probability": 0.88},
            {"effects": ["unknown"], "probability": 0.12},
        ],
        "causes": [
            {
                "effect": "trapped_charge",
                "probability": 0.88,
                "delta_elpd": 41.0,
                "delta_elpd_se": 8.0,
                "closure": 0.89,
                "closure_interval": [0.8, 0.96],
                "adequate_after": True,
                "indistinguishable_from": [],
                "parameters": {"residual_fraction": {"mean": 0.2, "sd": 0.03, "unit": "1"}},
            },
            {"effect": "unknown", "probability": 0.12},
            {"effect": "none", "probability": 0.0},
        ],
        "verdict": {
            "effects": ["trapped_charge"],
            "probability": 0.88,
            "alternatives": [],
            "why": "Slow at low frequency.",
        },
        "closure": {
            "before": 3.1,
            "after": 1.27,
            "noise_floor": 1.05,
            "shrinkage": 0.89,
            "interval": [0.8, 0.96],
            "held_out_by": "condition",
        },
        "absorbed": {
            "force_multiplier": {"before": 1.4, "after": 1.05, "unit": "1", "shift_posterior_sd": 3.2}
        },
        "next_experiment": [],
    }
