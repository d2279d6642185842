"""What a diagnosis starts from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from eaclutch.records import Bench, BurstFeatures, CapacitanceReadings, Spectrum


@dataclass(frozen=True)
class DiagnosisInputs:
    """What a diagnosis starts from.

    table: runs.csv. readings, spectra, bursts: the calibration bench (None or empty where there is none).
    effects: what the model has switched on; candidates: what may be named (default: all others).
    model_options: further keywords of ClutchModel (roughness rule, form of the force multiplier).
    priors: {parameter: (mean, sd)} that replace the built-in ones.
    """

    bench: Bench
    table: pd.DataFrame
    readings: CapacitanceReadings | None
    spectra: tuple[Spectrum, ...]
    bursts: BurstFeatures | None
    effects: tuple[str, ...]
    candidates: tuple[str, ...] = ()
    model_options: Mapping[str, Any] | None = None
    priors: Mapping[str, Sequence[float]] | None = None
