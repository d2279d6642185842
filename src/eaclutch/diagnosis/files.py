"""Read what a diagnosis needs from a campaign's results folder (tables written by earlier stages)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.files import read_table
from eaclutch.physics.effects import switched_on
from eaclutch.records import Bench, BurstFeatures, CapacitanceReadings, InputError, Spectrum


def read_inputs(results: Path, bench: Bench, settings: Mapping[str, Any]) -> DiagnosisInputs:
    """Inputs of a diagnosis from ``runs.csv``, ``gap.csv``, ``spectra.csv`` and ``bursts.csv``.

    settings: the config's ``model`` and ``diagnosis`` sections. Missing bench tables count as no data.
    Raises: InputError where runs.csv is missing or unreadable.
    """
    runs = _table(results / "runs.csv")
    if runs is None:
        raise InputError(results / "runs.csv", "missing or empty", "run the observables stage first")
    effects, options = model_of(settings)
    return DiagnosisInputs(
        bench,
        runs,
        readings(results / "gap.csv"),
        spectra(results / "spectra.csv"),
        bursts(results / "bursts.csv"),
        effects,
        tuple(settings.get("diagnosis", {}).get("candidates") or ()),
        options,
        settings.get("priors") or {},
    )


def model_of(settings: Mapping[str, Any]) -> tuple[tuple[str, ...], dict[str, Any]]:
    """Effects that are switched on, and the keywords of ClutchModel, from the config's ``model`` section."""
    model = settings.get("model", {})
    keys = ("roughness_rule", "roughness_cut", "force_multiplier_form")
    return switched_on(model), {key: model[key] for key in keys if key in model}


def readings(path: Path) -> CapacitanceReadings | None:
    """Capacitance readings from gap.csv, None without any."""
    table = _table(path)
    if table is None:
        return None
    return CapacitanceReadings(
        table["force_n"].to_numpy(float),
        table["capacitance_pf"].to_numpy(float) * 1e-12,
        table["width_mm"].to_numpy(float) * 1e-3,
        tuple(map(str, table["trial"])),
        tuple(map(str, table["source"])),
    )


def spectra(path: Path) -> tuple[Spectrum, ...]:
    """Spectra from spectra.csv, one a source."""
    table = _table(path)
    if table is None:
        return ()
    return tuple(
        Spectrum(
            str(source),
            part["frequency_hz"].to_numpy(float),
            part["relative_permittivity"].to_numpy(float),
        )
        for source, part in table.groupby("source", sort=True)
    )


def bursts(path: Path) -> BurstFeatures | None:
    """Free swings of the load cell from bursts.csv, None without any."""
    table = _table(path)
    if table is None:
        return None
    return BurstFeatures(
        *(
            table[name].to_numpy(float)
            for name in ("frequency_hz", "frequency_hz_sd", "damping_ratio", "damping_ratio_sd")
        )
    )


def _table(path: Path) -> pd.DataFrame | None:
    table = read_table(path) if path.exists() else pd.DataFrame()
    return table if len(table) else None
