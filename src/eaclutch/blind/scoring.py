"""Scores of frozen verdicts against opened answers, each with an interval (contract: score of the benchmark)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import binomtest

from eaclutch.blind.outcome import outcome
from eaclutch.records import FloatArray

LEVEL = 0.9
BOOTSTRAPS = 2000
BINS = (0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0)
DISTANCES = (0.0, 2.0, 4.0, 8.0, 16.0, np.inf)  # standard deviations, after calibration
Z90 = 1.6448536269514722

Rows = list[dict[str, Any]]


def score(
    answers: Mapping[str, Mapping[str, Any]],
    verdicts: Mapping[str, Mapping[str, Mapping[str, Any]]],
    sides: Mapping[str, Mapping[str, Mapping[str, Any]]],
    forecast: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The score of every method: ``answers`` by case, ``verdicts`` and ``sides`` by method and case."""
    methods = {}
    for method, found in verdicts.items():
        rows = [
            outcome(case, answers[case], document, sides.get(method, {}).get(case, {}), method)
            for case, document in sorted(found.items())
        ]
        missing = sorted(set(answers) - set(found))
        methods[method] = scores(rows, identifiable(forecast)) | {"missing": missing, "rows": rows}
    kinds = [answer["kind"] for answer in answers.values()]
    counts = {kind: kinds.count(kind) for kind in ("none", "single", "unknown", "pair")}
    return {"schema": 1, "cases": len(answers), "kinds": counts, "methods": methods, "forecast": forecast}


def identifiable(forecast: Mapping[str, Any] | None) -> set[str]:
    """Effects that the frozen forecast calls identifiable; none without a forecast."""
    return set(map(str, (forecast or {}).get("identifiable") or ()))


def scores(rows: Rows, sure: Collection[str] = ()) -> dict[str, Any]:
    """All scores of one method from its rows; ``sure``: effects that were forecast to be identifiable."""
    kind = {name: [r for r in rows if r["kind"] == name] for name in ("none", "single", "unknown", "pair")}
    effect = kind["single"] + kind["pair"]
    expected = [r for r in kind["single"] if r["truth"][0] in sure]
    exact = [r for r in effect if r["right"]]
    return {
        "right": share(rows, "right"),
        "right_by_kind": {name: share(part, "right") for name, part in kind.items()},
        "identifiable": {
            "first": share(expected, "first"),
            "probability_of_truth": mean(expected, "probability_of_truth"),
            "effects": sorted({r["truth"][0] for r in expected}),
        },
        "first": share(rows, "first"),
        "first_two": share(rows, "first_two"),
        "probability_of_truth": mean(rows, "probability_of_truth"),
        "probability_of_truth_by_kind": {n: mean(part, "probability_of_truth") for n, part in kind.items()},
        "log_score": mean(rows, "log_score"),
        "brier": mean(rows, "brier"),
        "set_holds_truth": share(rows, "in_set"),
        "set_holds_truth_by_kind": {name: share(part, "in_set") for name, part in kind.items()},
        "set_size": mean(rows, "set_size") | {"largest": max((r["set_size"] for r in rows), default=None)},
        "false_alarms": share(kind["none"], "named"),
        "unknown_said_without_gap": share(kind["none"], "said_unknown"),
        "unknown_recognised": share(kind["unknown"], "said_unknown"),
        "wrong_name_on_unknown": share(kind["unknown"], "named"),
        "wrong_name_on_effect": share(effect, "wrong_name"),
        "left_out": {"unknown": share(rows, "left_out_unknown"), "named": share(rows, "left_out_named")},
        "where": {key: share(effect, f"where_{key}") for key in ("observable", "phase", "factor")},
        "closure": {
            "error": mean(exact, "closure_error"),
            "absolute_error": mean(exact, "closure_error", np.abs),
            "covered": share([r for r in effect if r["closure_covered"] is not None], "closure_covered"),
        },
        "parameters": {name: _bias(exact, name) for name in ("contact_stiffness", "roughness_sd")},
        "calibration": calibration(rows),
        "by_effect": by_effect(kind["single"]),
        "by_distance": by_distance(kind["single"]),
        "by_level": {
            level: share([r for r in rows if r["level"] == level], "right") for level in ("tables", "logs")
        },
        "confusion": confusion(rows),
        "strangers": confusion(kind["unknown"], "put_in"),
        "seconds": mean(rows, "seconds"),
    }


def share(rows: Rows, key: str) -> dict[str, Any]:
    """Share of the rows that are true at ``key`` with its exact binomial interval; rows of None do not count."""
    known = [bool(r[key]) for r in rows if r[key] is not None]
    if not known:
        return {"value": None, "interval": None, "count": 0, "of": 0}
    hits = sum(known)
    interval = binomtest(hits, len(known)).proportion_ci(LEVEL, "exact")
    return {
        "value": hits / len(known),
        "interval": [float(interval.low), float(interval.high)],
        "count": hits,
        "of": len(known),
    }


def mean(rows: Rows, key: str, of: Callable[[FloatArray], FloatArray] = np.asarray) -> dict[str, Any]:
    """Mean over the rows with its bootstrap interval; rows of None do not count."""
    values = of(np.array([r[key] for r in rows if r[key] is not None], dtype=float))
    if len(values) == 0:
        return {"value": None, "interval": None, "of": 0}
    return {"value": float(values.mean()), "interval": _bootstrap(values, np.mean), "of": len(values)}


def _bootstrap(values: FloatArray, statistic: Callable[..., Any]) -> list[float]:
    """Percentile interval over cases; the stream is fixed, so that a score is the same every time."""
    draws = np.random.default_rng(len(values)).integers(0, len(values), (BOOTSTRAPS, len(values)))
    low, high = np.quantile(statistic(values[draws], axis=1), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return [float(low), float(high)]


def _bias(rows: Rows, name: str) -> dict[str, Any]:
    """Mean error in posterior sd before and after the right effect was added, and coverage of 90 % intervals."""
    out: dict[str, Any] = {}
    for when in ("before", "after"):
        key = f"{name}_error_{when}"
        known = [r for r in rows if r[key] is not None]
        inside = [{"inside": abs(r[key]) <= Z90} for r in known]
        out[when] = {
            "bias": mean(known, key),
            "size": mean(known, key, np.abs),
            "covered": share(inside, "inside"),
        }
    return out


def calibration(rows: Rows) -> dict[str, Any]:
    """Stated probability of the verdict against how often it is right, in bins, and the mean distance of both."""
    stated = np.array([r["probability"] for r in rows], dtype=float)
    right = np.array([r["right"] for r in rows], dtype=float)
    place = np.clip(np.digitize(stated, BINS[1:-1]), 0, len(BINS) - 2)
    bins, error = [], 0.0
    for i in range(len(BINS) - 1):
        inside = place == i
        if inside.any():
            gap = float(stated[inside].mean() - right[inside].mean())
            error += abs(gap) * inside.mean()
            part = [{"right": bool(value)} for value in right[inside]]
            bins.append({"stated": float(stated[inside].mean()), "right": share(part, "right")})
    pairs = np.stack([stated, right], axis=-1) if len(rows) else np.empty((0, 2))
    interval = _bootstrap_error(pairs) if len(rows) else None
    return {"bins": bins, "error": float(error) if len(rows) else None, "interval": interval}


def _bootstrap_error(pairs: FloatArray) -> list[float]:
    draws = np.random.default_rng(len(pairs)).integers(0, len(pairs), (400, len(pairs)))
    errors = []
    for draw in pairs[draws]:
        place = np.clip(np.digitize(draw[:, 0], BINS[1:-1]), 0, len(BINS) - 2)
        total = np.bincount(place, draw[:, 0] - draw[:, 1], len(BINS) - 1)
        errors.append(np.abs(total).sum() / len(draw))
    low, high = np.quantile(errors, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return [float(low), float(high)]


def by_effect(rows: Rows) -> list[dict[str, Any]]:
    """Each true effect that was put in alone: how often it was found and what probability it got."""
    names = sorted({name for r in rows for name in r["truth"]})
    out = []
    for name in names:
        part = [r for r in rows if r["truth"] == [name]]
        row = {"effect": name, "right": share(part, "right"), "in_set": share(part, "in_set")}
        out.append(row | {"probability_of_truth": mean(part, "probability_of_truth")})
    return out


def by_distance(rows: Rows) -> list[dict[str, Any]]:
    """Single effects by how far they lie from the base model after calibration, in standard deviations."""
    out = []
    for low, high in itertools.pairwise(DISTANCES):
        part = [r for r in rows if low <= r["distance"] < high]
        row = {"from": low, "to": None if np.isinf(high) else high, "right": share(part, "right")}
        out.append(row | {"named": share(part, "named"), "in_set": share(part, "in_set")})
    return out


def confusion(rows: Rows, key: str = "truth") -> list[dict[str, Any]]:
    """Counts of (truth, verdict); ``key`` "put_in": of what the generator did, by its own name."""
    pairs = sorted((_label(r[key]), _label(r["said"])) for r in rows)
    return [{"truth": t, "said": s, "count": pairs.count((t, s))} for t, s in sorted(set(pairs))]


def _label(names: Sequence[str]) -> str:
    return "+".join(sorted(names)) or "none"
