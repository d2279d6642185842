"""One verdict held against one answer: a flat row of what was right, from which all scores are means."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from eaclutch.records import InputError

FLOOR = 1e-4  # probability below which a log score is not pushed further
NEAR = 0.8  # a factor counts as the truth's when it explains this share of what the best one does
LEAST_SHARE = 0.15  # of the gap, from which an observable is one of its places
LEAVE_OUT = "without-"

Names = frozenset[str]


def right_answer(answer: Mapping[str, Any], method: str) -> Names:
    """What the method should have said: an effect that was taken out of its library is unknown to it."""
    truth = frozenset(answer["verdict"])
    if method.startswith(LEAVE_OUT) and method.removeprefix(LEAVE_OUT) in truth:
        return frozenset({"unknown"})
    return truth


def outcome(
    case: str, answer: Mapping[str, Any], document: Mapping[str, Any], side: Mapping[str, Any], method: str
) -> dict[str, Any]:
    """The row of one case. Raises InputError where the verdict file is not of the contract's shape."""
    truth = right_answer(answer, method)
    try:
        hypotheses = {
            frozenset(map(str, item["effects"])): float(item["probability"])
            for item in document["hypotheses"]
        }
        said = frozenset(map(str, document["verdict"]["effects"]))
        confidence = float(document["verdict"]["probability"])
        offered = [said, *(frozenset(map(str, item)) for item in document["verdict"]["alternatives"])]
        places = list(document["where"])
        closure = dict(document["closure"])
    except (KeyError, TypeError, ValueError) as error:
        what = f"the verdict on {case} is not a diagnosis.json ({type(error).__name__}: {error})"
        raise InputError(f"{method}/{case}.json", what, "write it as the contract says") from None
    ranked = sorted(hypotheses, key=lambda names: (-hypotheses[names], sorted(names)))
    on_truth = min(max(hypotheses.get(truth, 0.0), 0.0), 1.0)
    brier = sum(p**2 for names, p in hypotheses.items() if names != truth) + (1 - on_truth) ** 2
    row = {
        "case": case,
        "kind": answer["kind"],
        "level": answer.get("level", "tables"),
        "truth": sorted(truth),
        "put_in": sorted(str(item["effect"]) for item in answer.get("effects") or ()),
        "said": sorted(said),
        "probability": confidence,
        "right": said == truth,
        "first": bool(ranked) and ranked[0] == truth,
        "first_two": truth in ranked[:2],
        "in_set": truth in offered,
        "set_size": len(set(offered)),
        "probability_of_truth": on_truth,
        "log_score": float(np.log(max(on_truth, FLOOR))),
        "brier": float(brier),
        "named": bool(said - {"unknown"}),
        "wrong_name": bool(said - {"unknown"} - truth),
        "said_unknown": said == {"unknown"},
        "distance": answer["truth"]["distance_calibrated"],
        "seconds": (side.get("run") or {}).get("seconds"),
    }
    return (
        row
        | _left_out(side, answer)
        | _where(places, answer)
        | _closure(said, closure, answer)
        | _parameters(side, answer)
    )


def _left_out(side: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, Any]:
    """What was said without the true effect in the library, where it was put in alone; None where not known."""
    given = (side.get("without") or {}).get(answer["verdict"][0]) if answer["kind"] == "single" else None
    if given is None:
        return {"left_out_unknown": None, "left_out_named": None}
    said = set(map(str, given["effects"]))
    return {"left_out_unknown": said == {"unknown"}, "left_out_named": bool(said - {"unknown"})}


def _where(places: list[Mapping[str, Any]], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Whether the first place that was named is one of the truth's; None where there is no gap to place."""
    truth = [row for row in answer["truth"]["where"] if row["share"] >= LEAST_SHARE]
    if not truth:
        return {"where_observable": None, "where_phase": None, "where_factor": None}
    if not places:
        return {"where_observable": False, "where_phase": False, "where_factor": False}
    top = max(places, key=lambda row: float(row.get("share") or 0.0))
    said_factors = {top.get("factor"), *(top.get("confounded_with") or ())}
    same = next(
        (row for row in truth if family(row["observable"]) == family(str(top.get("observable")))), None
    )
    factors = (same or truth[0])["factors"]
    best = max(value for name, value in factors.items())
    good = {name for name, value in factors.items() if value >= NEAR * best}
    return {
        "where_observable": same is not None,
        "where_phase": top.get("phase") in {row["phase"] for row in truth},
        "where_factor": bool(said_factors & good),
    }


def family(observable: str) -> str:
    """Observables that carry the same news count as one: three release times, three ramp rates, levels at rest."""
    for start, name in (
        ("release_time", "release"),
        ("ramp_rate", "ramp"),
        ("capacitance", "capacitance"),
        ("final", "level"),
        ("baseline", "level"),
    ):
        if observable.startswith(start):
            return name
    return observable


def _closure(said: Names, closure: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Closure against the true one of what was named; None where no effect of the truth was named alone."""
    true = answer["truth"]["closure"].get("+".join(sorted(said)))
    if true is None or closure.get("shrinkage") is None:
        return {"closure_true": None, "closure_error": None, "closure_covered": None}
    low, high = closure["interval"]
    return {
        "closure_true": true,
        "closure_error": float(closure["shrinkage"]) - true,
        "closure_covered": bool(float(low) <= true <= float(high)),
    }


def _parameters(side: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Errors of contact stiffness and roughness in posterior sd, by the base model and with the verdict."""
    found: dict[str, Any] = {}
    given = side.get("parameters") or {}
    for name in ("contact_stiffness", "roughness_sd"):
        for when in ("before", "after"):
            entry = (given.get(when) or {}).get(name)
            error = None
            if entry and entry.get("sd"):
                error = (float(entry["mean"]) - answer["parameters"][name]) / float(entry["sd"])
            found[f"{name}_error_{when}"] = error
    return found
