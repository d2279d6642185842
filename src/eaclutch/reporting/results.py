"""All that a page shows of a campaign, read from its results folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from eaclutch.files import read_json, read_table
from eaclutch.records import FloatArray, InputError, ObservableInfo

STAGES = ("contact", "dielectric", "load_cell", "force")


@dataclass(frozen=True)
class StageDraws:
    """A stage's draws, each (chains, draws), the prior's draws, units, and log density (chains, draws)."""

    posterior: Mapping[str, FloatArray]
    prior: Mapping[str, FloatArray]
    units: Mapping[str, str]
    log_density: FloatArray | None
    notes: str


@dataclass(frozen=True)
class Results:
    """A campaign's results: tables as they lie in the folder, traces by run, draws by stage."""

    folder: Path
    capture: Mapping[str, Any]
    runs: pd.DataFrame
    observables: Mapping[str, ObservableInfo]
    quality: Mapping[str, Any]
    gap: pd.DataFrame
    spectra: pd.DataFrame
    bursts: pd.DataFrame
    traces: Mapping[str, FloatArray]
    draws: Mapping[str, StageDraws]
    summary: Mapping[str, Any]
    predictions: pd.DataFrame
    coverage: Mapping[str, Any]
    diagnosis: Mapping[str, Any]

    def predicted(self, observable: str | None = None) -> pd.DataFrame:
        """Predictions with a number and a measurement, of conditions that the fit did not see where there are such."""
        rows = self.predictions
        if observable is not None:
            rows = rows[rows["observable"] == observable]
        held = rows["held_out"].astype(str).str.lower() == "true"
        rows = rows[held] if held.any() else rows
        return rows[(rows["status"] == "ok") & rows["measured"].notna() & rows["median"].notna()]

    @property
    def name(self) -> str:
        """The campaign's name."""
        return str(self.capture["campaign"])


def read_results(folder: Path) -> Results:
    """Read ``results/<name>``. Raises InputError that names the file that is missing or broken."""

    def table(name: str) -> pd.DataFrame:
        return read_table(folder / name)

    try:
        capture = read_json(folder / "capture.json")
        traces: dict[str, FloatArray] = {}
        for batch in capture["batches"]:
            with np.load(folder / f"observables/traces_{batch}.npz", allow_pickle=False) as arrays:
                traces |= {run: arrays[run] for run in arrays.files}
        return Results(
            folder=folder,
            capture=capture,
            runs=table("runs.csv"),
            observables={
                item["name"]: ObservableInfo(**item) for item in read_json(folder / "observables.json", list)
            },
            quality=read_json(folder / "quality.json"),
            gap=table("gap.csv"),
            spectra=table("spectra.csv"),
            bursts=table("bursts.csv"),
            traces=traces,
            draws={stage: read_draws(folder / f"posterior/{stage}.nc") for stage in STAGES},
            summary=read_json(folder / "posterior/summary.json"),
            predictions=table("predict/runs.csv"),
            coverage=read_json(folder / "predict/coverage.json"),
            diagnosis=read_json(folder / "diagnosis/diagnosis.json"),
        )
    except (OSError, KeyError) as error:
        raise InputError(folder, f"is incomplete ({error})", "run the campaign to its end") from error


def read_draws(path: Path) -> StageDraws:
    """The draws of a stage from its InferenceData file; vectors keep their first two axes only if scalar."""
    with xr.open_datatree(path, engine="h5netcdf") as tree:
        posterior = {str(name): variable for name, variable in tree["posterior"].data_vars.items()}
        scalars = {name: variable for name, variable in posterior.items() if variable.ndim == 2}
        prior = {
            str(name): np.asarray(variable).ravel()
            for name, variable in tree["prior"].data_vars.items()
            if variable.ndim == 2
        }
        density = tree["sample_stats"].data_vars.get("lp") if "sample_stats" in tree else None
        return StageDraws(
            posterior={name: np.asarray(variable) for name, variable in scalars.items()},
            prior=prior,
            units={name: str(variable.attrs.get("unit", "1")) for name, variable in scalars.items()},
            log_density=None if density is None else np.asarray(density),
            notes=str(tree.attrs.get("notes", "")),
        )
