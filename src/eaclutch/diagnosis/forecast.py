"""Confusability known beforehand: what this design and model could tell apart, before any data are looked at.

Everything is done on signatures: how far an effect moves the entries of a campaign that the base model itself
predicts. Data are simulated around them with repeat noise, session spread, the base laws' tolerance and an error
of the effect's own law, and weighed by the same prior odds and temperature as real ones, with each law's free
parameters replaced by a cloud of sizes. Without pairs, absolute check and ``against_unknown``, so it is more lenient
than a verdict: a name leads the nameless terms by all of its nats.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from eaclutch.diagnosis.clouds import cloud_of
from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.hypothesis import effect_shifts, neutral_parameters
from eaclutch.diagnosis.modulated import changes, gains
from eaclutch.diagnosis.starts import scout_shifts
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.weigh import log_prior, named_scale
from eaclutch.physics.effects import EFFECTS
from eaclutch.records import FloatArray

DRAWS = 12  # parameter sets of each effect
REPLICAS = 10  # data sets simulated from each
NONE_REPLICAS = 200
SIZES = np.geomspace(0.05, 4.0, 10)  # of a typical draw
SURE = 0.8  # probability of the right verdict that makes an effect identifiable


class Forecast:
    """The expected confusion matrix and detection limits of one design."""

    def __init__(self, study: Study):
        """``study``: of a table that the base model predicts (``planned_table``)."""
        self.study = study
        base = study.base
        self.kernels: Kernels = study.kernels
        self.covariance = base.linearised.marginal()
        self.root = np.linalg.cholesky(self.covariance)
        self.clouds, lookalikes = (
            [
                cloud_of(
                    scout_shifts(study.forward((name,)), base)[0],
                    self._law_share(name),
                    self._whiten,
                    self.kernels.smooth,
                )
                for name in names
            ]
            for names in (study.candidates, study.lookalikes)
        )
        self.names = [*study.candidates, "unknown", "none"]
        thresholds = study.thresholds
        prior = thresholds["prior"]
        single = [log_prior((name,), study.candidates, prior) for name in study.candidates]
        self.log_prior = np.array([*single, np.log(prior["unknown"]), log_prior((), study.candidates, prior)])
        less = float(np.log(prior["lookalike_share"]))
        odds = [less + log_prior((name,), study.candidates, prior) for name in study.lookalikes]
        self.lookalikes = list(zip(lookalikes, odds, strict=True))
        self.nameless_roots = [
            np.linalg.cholesky(self.covariance + self.kernels.tolerance * (factor**2 - 1.0))
            for factor in thresholds["nameless"]["factors"]
            if factor > 1.0
        ]
        self.laws = [
            self._whiten(columns.T).T for _, _, columns in changes(base.mode, study.data, thresholds)
        ]
        self.nameless_cost = float(-np.log(thresholds["nameless"]["free_share"] / len(self.nameless_roots)))

    def _whiten(self, w: FloatArray) -> FloatArray:
        return solve_triangular(self.root, w.T, lower=True).T

    def verdicts(self, w: FloatArray) -> np.ndarray:
        """Index into ``names`` of the most probable hypothesis for data (sets, entries)."""
        a = self._whiten(w)
        plain = -0.5 * np.sum(a**2, axis=1)
        log_det = float(np.sum(np.log(np.diag(self.root))))
        scores = [cloud.evidence(a) for cloud in self.clouds]
        nameless = []
        for root in self.nameless_roots:
            z = solve_triangular(root, w.T, lower=True)
            nameless.append(-0.5 * np.sum(z**2, axis=0) - np.sum(np.log(np.diag(root))) + log_det)
        scores.append(self._with_laws(logsumexp(nameless, axis=0) - self.nameless_cost, plain, a.T))
        scores.append(plain)
        temperature = self.study.thresholds["temperature"]
        total = np.stack(scores, axis=1) / temperature + self.log_prior
        unknown = self.names.index("unknown")
        for cloud, prior in self.lookalikes:
            looks = cloud.evidence(a) / temperature + prior
            total[:, unknown] = np.logaddexp(total[:, unknown], looks)
        weights = np.exp(total - logsumexp(total, axis=1, keepdims=True))
        odds = float(self.study.thresholds["unknown_odds"])
        names, nameless = weights[:, :unknown].sum(axis=1), weights[:, unknown]
        weights[:, : unknown + 1] *= named_scale(names, nameless + np.finfo(float).tiny, odds)[:, None]
        weights[:, unknown] *= odds
        return np.argmax(weights, axis=1)

    def _with_laws(self, smooth: FloatArray, plain: FloatArray, white: FloatArray) -> FloatArray:
        """Evidence (sets,) of a nameless term of either kind (``remainder``)."""
        if not self.laws:
            return smooth
        settings = self.study.thresholds["modulated"]
        gained = np.concatenate([gains(moved, white, np.array(settings["sizes"])) for moved in self.laws])
        law = plain + logsumexp(gained, axis=0) - np.log(len(gained))
        return np.logaddexp(smooth + np.log1p(-settings["share"]), law + np.log(settings["share"]))

    def _law_share(self, name: str) -> float:
        """By what share of its signature an effect's own law may be off."""
        return 0.0 if EFFECTS[name].exact else float(self.study.thresholds["signature_tolerance"])

    def simulate(
        self, shift: FloatArray, replicas: int, rng: np.random.Generator, share: float
    ) -> FloatArray:
        """Data (replicas, entries) with an effect that moves them by ``shift`` (entries,), its law off by ``share``."""
        total = self.covariance + self.kernels.smooth * np.outer(share * shift, share * shift)
        root = np.linalg.cholesky(total)
        return shift + rng.standard_normal((replicas, len(shift))) @ root.T

    def true_shifts(self, name: str, rng: np.random.Generator) -> tuple[list[dict[str, float]], FloatArray]:
        """Plausible parameter sets of an effect and how far each moves the entries, (draws, entries)."""
        forward = self.study.forward((name,))
        base = self.study.base.parameters
        draws = [EFFECTS[name].draw(rng) for _ in range(DRAWS)]
        known = {p.name: p for p in forward.parameters}
        theta = np.array(
            [
                [d.get(n.split(".", 1)[-1], known[n].default) if forward.own(n) else base[n] for n in known]
                for d in draws
            ]
        )
        theta = np.clip(theta, [p.bounds[0] for p in known.values()], [p.bounds[1] for p in known.values()])
        return draws, effect_shifts(forward, theta, neutral_parameters(forward, theta[0]), (name,))

    def document(self, rng: np.random.Generator) -> dict[str, Any]:
        """confusion.json: {truth: {verdict: probability}}, limits, which effects are identifiable."""
        none = self.simulate(np.zeros(len(self.study.data)), NONE_REPLICAS, rng, 0.0)
        matrix = {"none": self._share(self.verdicts(none))}
        limits = {}
        for name in self.study.candidates:
            draws, shifts = self.true_shifts(name, rng)
            share = self._law_share(name)
            data = np.concatenate([self.simulate(shift, REPLICAS, rng, share) for shift in shifts])
            matrix[name] = self._share(self.verdicts(data))
            limits[name] = self._limit(name, draws, shifts, rng)
        return {
            "schema": 1, "campaign": self.study.inputs.bench.name,
            "model": {"effects": list(self.study.inputs.effects)},
            "matrix": matrix, "limits": limits,
            "identifiable": [n for n in self.study.candidates if limits[n]["size"] is not None],
        }  # fmt: skip

    def _share(self, verdicts: np.ndarray) -> dict[str, float]:
        counts = np.bincount(verdicts, minlength=len(self.names)) / len(verdicts)
        return {name: float(c) for name, c in zip(self.names, counts, strict=True)}

    def _limit(
        self, name: str, draws: Sequence[Mapping[str, float]], shifts: FloatArray, rng: np.random.Generator
    ) -> dict[str, Any]:
        """Smallest size, as a multiple of the typical draw, from which the right verdict has the probability SURE."""
        strength = np.linalg.norm(self._whiten(shifts), axis=1)
        typical = int(np.argsort(strength)[len(strength) // 2])
        index = self.names.index(name)
        right = []
        for size in SIZES:
            data = self.simulate(size * shifts[typical], 4 * REPLICAS, rng, self._law_share(name))
            right.append(float(np.mean(self.verdicts(data) == index)))
        # also on average over all that is larger: a law that saturates may be confused again
        sure = [i for i in range(len(SIZES)) if right[i] >= SURE and float(np.mean(right[i:])) >= SURE]
        size = float(SIZES[sure[0]]) if sure else None
        amplitudes = {p.name for p in EFFECTS[name].parameters if p.neutral is not None}
        return {
            "size": size, "distance": float(strength[typical] * (size or SIZES[-1])),
            "parameters": {k: v * (size or SIZES[-1]) if k in amplitudes else v for k, v in draws[typical].items()},
            "probability_by_size": {f"{s:.3g}": r for s, r in zip(SIZES, right, strict=True)},
        }  # fmt: skip
