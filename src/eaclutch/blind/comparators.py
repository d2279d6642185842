"""What simpler methods would say from the same fits: their verdicts, in the contract's shape.

They work on plain numbers that any fitting code could hand over (``Fits``). Everything that is not part of the
simple method (places, intervals) is left empty or as wide as it can be.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import logsumexp, softmax
from scipy.stats import chi2

from eaclutch.records import FloatArray, InputError

Names = tuple[str, ...]
SETTLED = 0.9  # weight at which no alternative is offered
GATE = 0.01  # p-value of the base model's chi-squared from which a simple method sees a gap


@dataclass(frozen=True)
class Fits:
    """Fits of all hypotheses to one campaign, the base model's (no names) first.

    errors: measured less predicted by (observable, condition) cell, in units of the cell's repeat error,
    (hypotheses, cells); left_out: the same on conditions that the fit did not see; log_density: of each
    left-out condition, (hypotheses, conditions); sizes: own parameters of each hypothesis, (hypotheses,);
    nameless_gain: log evidence of a smooth nameless term over the base model's (nats).
    """

    effects: tuple[Names, ...]
    errors: FloatArray
    left_out: FloatArray
    log_density: FloatArray
    sizes: FloatArray
    nameless_gain: float

    @classmethod
    def read(cls, document: Mapping[str, Any]) -> Fits:
        """From plain JSON (keys as the fields)."""
        effects = tuple(tuple(names) for names in document["effects"])
        arrays = {
            key: np.array(document[key], float) for key in ("errors", "left_out", "log_density", "sizes")
        }
        return cls(effects, **arrays, nameless_gain=float(document["nameless_gain"]))


def criterion_weights(fits: Fits, penalty: float) -> dict[Names, float]:
    """Akaike-like weights exp(-IC / 2), IC = chi-squared + penalty x own parameters."""
    cost = np.sum(fits.errors**2, axis=1) + penalty * fits.sizes
    return dict(zip(fits.effects, softmax(-cost / 2).tolist(), strict=True))


def forward_selection(fits: Fits, penalty: float) -> tuple[dict[Names, float], Names]:
    """Add the effect that lowers the criterion most, while one does; weights as in ``criterion_weights``."""
    cost = np.sum(fits.errors**2, axis=1) + penalty * fits.sizes
    current: Names = ()
    while True:
        index = fits.effects.index(current)
        wider = [
            i
            for i, names in enumerate(fits.effects)
            if len(names) == len(current) + 1 and set(current) <= set(names)
        ]
        best = min(wider, key=lambda i: cost[i], default=index)
        if cost[best] >= cost[index]:
            return criterion_weights(fits, penalty), current
        current = fits.effects[best]


def aic(fits: Fits) -> tuple[dict[Names, float], Names]:
    """Forward selection by Akaike's criterion."""
    return forward_selection(fits, 2.0)


def bic(fits: Fits) -> tuple[dict[Names, float], Names]:
    """Forward selection by Schwarz's criterion; the cells count as observations."""
    return forward_selection(fits, float(np.log(fits.errors.shape[1])))


def largest_residual(fits: Fits) -> tuple[dict[Names, float], Names]:
    """Rank single effects by how much of the base model's largest residuals (a tenth of the cells) they remove."""
    base = fits.effects.index(())
    squares = fits.errors[base] ** 2
    worst = np.argsort(-squares)[: max(1, len(squares) // 10)]
    singles = [i for i, names in enumerate(fits.effects) if len(names) == 1]
    removed = 1 - np.sum(fits.errors[singles][:, worst] ** 2, axis=1) / np.sum(squares[worst])
    gap = chi2.sf(np.sum(squares), len(squares)) < GATE
    weights: dict[Names, float] = {(): 0.02 if gap else 0.98}
    shares = softmax(10 * removed) * (1 - weights[()])
    weights |= {fits.effects[i]: float(share) for i, share in zip(singles, shares, strict=True)}
    return weights, max(weights, key=lambda names: weights[names])


def loo(fits: Fits) -> tuple[dict[Names, float], Names]:
    """Pseudo-BMA+ weights of leave-one-condition-out densities (Yao et al. 2018, DOI 10.1214/17-BA1091)."""
    draws = np.random.default_rng(0).dirichlet(np.ones(fits.log_density.shape[1]), 1000)
    total = draws @ fits.log_density.T * fits.log_density.shape[1]
    weights = np.exp(total - logsumexp(total, axis=1, keepdims=True)).mean(axis=0)
    named = dict(zip(fits.effects, weights.tolist(), strict=True))
    return named, max(named, key=lambda names: named[names])


def nameless(fits: Fits) -> tuple[dict[Names, float], Names]:
    """A nameless smooth term: it says that there is a gap, and never what it is."""
    unknown = float(1 / (1 + np.exp(-np.clip(fits.nameless_gain, -50, 50))))
    weights: dict[Names, float] = {(): 1 - unknown, ("unknown",): unknown}
    return weights, ("unknown",) if unknown > 0.5 else ()


COMPARATORS: dict[str, Callable[[Fits], tuple[dict[Names, float], Names]]] = {
    "aic": aic,
    "bic": bic,
    "largest_residual": largest_residual,
    "loo": loo,
    "nameless_gp": nameless,
}


def compare(name: str, fits: Fits, campaign: str) -> dict[str, Any]:
    """The comparator's verdict on a campaign (contract: diagnosis.json). Raises InputError for an unknown name."""
    if name not in COMPARATORS:
        raise InputError(f"method {name}", "is not known", f"take one of {', '.join(COMPARATORS)}")
    weights, said = COMPARATORS[name](fits)
    ranked = sorted(weights, key=lambda names: (-weights[names], names))
    closure = _closure(fits, said)
    return {
        "schema": 1,
        "campaign": campaign,
        "model": {"effects": []},
        "gap": {"total": {k: closure[k] for k in ("before", "after", "noise_floor")} | {"interval": [0.0, 1e6]},
                "by_observable": {}},
        "where": [],
        "hypotheses": [{"effects": list(names), "probability": weights[names]} for names in ranked],
        "causes": [],
        "verdict": {
            "effects": list(said),
            "probability": weights[said],
            "alternatives": _alternatives(weights, ranked, said),
            "why": f"{name} puts {', '.join(said) or 'nothing'} first",
        },
        "closure": closure,
        "absorbed": {},
        "next_experiment": [],
    }  # fmt: skip


def _alternatives(weights: Mapping[Names, float], ranked: Sequence[Names], said: Names) -> list[list[str]]:
    """The next most probable sets, until nine tenths of the weight are named, three at most."""
    total = weights[said]
    found: list[list[str]] = []
    for names in ranked:
        if total >= SETTLED or len(found) == 3:
            break
        if names != said:
            found.append(list(names))
            total += weights[names]
    return found


def _closure(fits: Fits, said: Names) -> dict[str, Any]:
    """Before and after on left-out conditions, with a floor of one and the widest interval."""
    means = np.mean(fits.left_out**2, axis=1)
    before = float(means[fits.effects.index(())])
    after = float(means[fits.effects.index(said)]) if said in fits.effects else before
    shrinkage = (before - after) / (before - 1) if before > 1 else 0.0
    return {"before": before, "after": after, "noise_floor": 1.0, "shrinkage": shrinkage, "interval": [0.0, 1.0],
            "held_out_by": "condition"}  # fmt: skip
