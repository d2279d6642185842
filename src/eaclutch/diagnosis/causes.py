"""The ``causes`` of diagnosis.json: what each candidate alone would explain, and at which values of its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from eaclutch.diagnosis.closure import gap_numbers
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.weigh import NONE, by_effect
from eaclutch.records import FloatArray


def causes(
    study: Study,
    results: Sequence[CandidateResult],
    weights: Mapping[tuple[str, ...], float],
    squares: FloatArray,
) -> list[dict[str, Any]]:
    """One entry a candidate, and one each for ``unknown`` and ``none``, the most probable first.

    What closes, and the gain, are of the effect alone; its parameters are those of the most probable set that holds it,
    for alone it would stand in for others.
    """
    base = next(r for r in results if r.effects == NONE)
    single = {r.effects[0]: r for r in results if len(r.effects) == 1}
    marginal = by_effect(weights)
    entries = []
    for name in [*study.candidates, "unknown", "none"]:
        result = single.get(name, base)
        gain = np.array(result.log_density) - np.array(base.log_density)
        closure = gap_numbers(study.cells, base, result, squares, study.generator(12))
        entries.append(
            {
                "effect": name, "probability": marginal.get(name, 0.0),
                "delta_elpd": float(gain.sum()),
                "delta_elpd_se": float(np.std(gain, ddof=1) * np.sqrt(len(gain))) if len(gain) > 1 else 0.0,
                "closure": closure["shrinkage"], "closure_interval": closure["interval"],
                "adequate_after": bool(
                    result.adequate_p >= study.thresholds["verdict"]["adequate_p_value"]
                ),
                "parameters": own_parameters(name, results, weights),
                "indistinguishable_from": indistinguishable(name, single, weights, study.thresholds),
            }
        )  # fmt: skip
    entries.sort(key=lambda entry: (-entry["probability"], entry["effect"]))
    return entries


def own_parameters(
    name: str, results: Sequence[CandidateResult], weights: Mapping[tuple[str, ...], float]
) -> dict[str, Any]:
    """{parameter: {mean, sd, unit}} of an effect in the most probable set that holds it; empty where none does."""
    holding = [r for r in results if name in r.effects]
    if not holding:
        return {}
    best = max(holding, key=lambda r: weights.get(r.effects, 0.0))
    if len(best.effects) == 1:
        return dict(best.parameters)
    return {
        full.removeprefix(f"{name}."): entry
        for full, entry in best.parameters.items()
        if full.startswith(f"{name}.")
    }


def indistinguishable(
    name: str,
    single: Mapping[str, CandidateResult],
    weights: Mapping[tuple[str, ...], float],
    thresholds: Mapping[str, Any],
) -> list[str]:
    """Other names whose own probability is within the stated factor of this one's, where this one matters."""
    mine, rules = weights.get((name,), 0.0), thresholds["verdict"]
    if name not in single or mine < rules["indistinguishable_from"]:
        return []
    factor = rules["indistinguishable_factor"]
    return sorted(
        other
        for other in single
        if other != name and 1 / factor <= weights.get((other,), 0.0) / mine <= factor
    )
