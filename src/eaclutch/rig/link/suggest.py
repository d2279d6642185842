"""A plan from what a diagnosis suggests to do next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from eaclutch.records import InputError
from eaclutch.rig.log_names import STANDARD_GRAVITY


def plan_from_suggestions(
    diagnosis: Mapping[str, Any], substrate: str, taken: Sequence[str] = (), seed: int = 1
) -> dict[str, Any]:
    """The plan document for ``next_experiment`` of a diagnosis.json; every suggested run is a new one.

    ``taken``: names of plans that exist; the new one gets another. Weights are whole grams (below half a
    gram: nothing is put on the film). Raises InputError where nothing is suggested.
    """
    where = f"diagnosis of {diagnosis.get('campaign', '?')}"
    suggestions = diagnosis.get("next_experiment") or []
    if not suggestions:
        raise InputError(
            where, "suggests no experiment", "its verdict stands, or the data cannot tell: see `why`"
        )
    conditions = []
    for suggestion in suggestions:
        try:
            preload = suggestion.get("preload_n")
            conditions.append(
                {
                    "voltage_v": float(suggestion["voltage_v"]),
                    "frequency_hz": float(suggestion["frequency_hz"]),
                    "width_mm": float(suggestion["width_mm"]),
                    "preload_g": -1 if preload is None else round(float(preload) / STANDARD_GRAVITY * 1e3),
                    "substrate": suggestion.get("substrate", substrate),
                    "repeats": int(suggestion["runs"]),
                }
            )
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(where, f"a suggestion cannot be read ({error})", "diagnose again") from None
    base = f"next-{diagnosis.get('campaign', 'campaign')}"[:60]
    name, number = base, 1
    while name in taken:
        number += 1
        name = f"{base}-{number}"
    return {"name": name, "seed": seed, "conditions": conditions, "count_existing": False}
