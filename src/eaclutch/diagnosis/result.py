"""What one hypothesis leaves behind for the verdict: plain numbers that travel as JSON between jobs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from eaclutch.diagnosis.cells import Cells
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.gate import adequacy, simulate_null
from eaclutch.diagnosis.gaussian import LeaveOut, Linearised, given, leave_out
from eaclutch.diagnosis.hypothesis import HypothesisFit, fitted_parameters
from eaclutch.diagnosis.remainder import Remainder
from eaclutch.records import FloatArray

FARTHEST = 5.0  # prior sds, of a parameter where a condition is left out
SHORTER = np.array([0.25, 0.5, 0.75])  # of the way to a refit that the model does not follow to its end


@dataclass(frozen=True)
class CandidateResult:
    """A weighed hypothesis.

    log_evidence (nats); log_evidence_open: of the effects with a nameless remainder beside them;
    log_evidence_without: of the base model fitted from where this fit stands, which may be better than where it was
    found by itself; log_evidence_without_open: of that with a nameless remainder. log_density: by
    left-out condition. gap_left_out: mean square of the left-out conditions' errors as the contract counts them
    (``Cells.mean_square``), 0 where there is one condition only.
    errors_left_out, errors: measured less predicted on the comparison scale, one an entry,
    without and with the entry's condition in the fit. shift: how far the effect moves each entry. adequate_p:
    absolute gate with the effect in, at usual tolerances; block_p: of each block in it. multipliers: the fit's most
    probable (tolerance, session); converged: whether it ended by itself. remainder_law: (quantity, setting) where the
    nameless remainder is best said so, else empty. repeat_drift [nats], of the base model: evidence
    that this campaign's repeats drift with the run order (``diagnosis.drift``). parameters: the
    effect's own (a pair's with its name in front); calibrated: {name: {mean, sd, unit, prior_sds}}.
    """

    effects: tuple[str, ...]
    log_evidence: float
    log_evidence_open: float
    log_evidence_without: float
    log_evidence_without_open: float
    log_density: tuple[float, ...]
    gap_left_out: float
    errors_left_out: tuple[float, ...]
    errors: tuple[float, ...]
    shift: tuple[float, ...]
    adequate_p: float
    block_p: Mapping[str, float]
    parameters: Mapping[str, Mapping[str, Any]]
    calibrated: Mapping[str, Mapping[str, Any]]
    multipliers: tuple[float, float]
    converged: bool
    remainder_law: tuple[str, ...]
    repeat_drift: float = 0.0

    @property
    def named(self) -> dict[str, float]:
        """Where the fit stands, {parameter: value}, those of an effect with its name in front."""
        own = {name if "." in name else f"{self.effects[0]}.{name}": e for name, e in self.parameters.items()}
        return {name: float(entry["mean"]) for name, entry in {**self.calibrated, **own}.items()}

    def document(self) -> dict[str, Any]:
        """JSON-able mapping."""
        return asdict(self)

    @classmethod
    def read(cls, document: Mapping[str, Any]) -> CandidateResult:
        """Inverse of ``document``."""
        sequences = (
            "effects",
            "log_density",
            "errors_left_out",
            "errors",
            "shift",
            "multipliers",
            "remainder_law",
        )
        fields: dict[str, Any] = {k: tuple(v) if k in sequences else v for k, v in document.items()}
        earlier: dict[str, Any] = {
            "gap_left_out": 0.0,
            "remainder_law": (),
        }  # what files of earlier versions lack
        return cls(**earlier | fields)


def condition_groups(data: DataVector) -> tuple[tuple[str, ...], list[np.ndarray]]:
    """Names of the conditions and the run entries of each."""
    names = tuple(dict.fromkeys(c for c in data.condition if c))
    return names, [np.flatnonzero(data.condition == name) for name in names]


def with_readings(fitted: HypothesisFit, readings: Mapping[str, float], *, usual: bool = False) -> Linearised:
    """A fit, or the same at ``usual`` tolerances, with the parameters of the reading held at ``readings`` (prior
    coordinates)."""
    known = {i: readings[name] for i, name in enumerate(fitted.mode.names) if name in readings}
    return given(fitted.usual if usual else fitted.linearised, known)


def left_out_errors(
    forward: Forward, data: DataVector, fitted: HypothesisFit, left: LeaveOut, readings: Mapping[str, float]
) -> FloatArray:
    """Measured less predicted (entries,) where each entry's condition is left out: the model itself at the parameters
    that the other conditions give it, for a law may bend far where it is extrapolated. Entries of no condition keep
    their residual.

    The parameters are those of the linearised refit; where the model follows it so badly that the conditions that
    stay are explained worse than before the step, the best point on the way counts, as a refit would have found."""
    names = fitted.mode.names
    held = {i: readings[name] for i, name in enumerate(names) if name in readings}
    u = np.empty((len(left.groups), len(names)))
    u[:, list(held)] = list(held.values())
    u[:, [i for i in range(len(names)) if i not in held]] = left.u
    u = np.clip(u, -FARTHEST, FARTHEST)
    start = fitted.mode.u.copy()
    start[list(held)] = list(held.values())
    precision = np.linalg.inv(fitted.linearised.covariance)

    def residual(points: FloatArray) -> FloatArray:
        return data.values - forward.predict(forward.priors.from_normal(points))

    arrived, begun = residual(u), residual(start[None])[0]
    errors = np.array(fitted.residual, dtype=float)
    for group, rows in enumerate(left.groups):
        points, found = np.stack([start, u[group]]), np.stack([begun, arrived[group]])
        stays = _stays(found, points, precision, rows)
        if stays[1] > stays[0]:
            between = start + SHORTER[:, None] * (u[group] - start)
            points, found = np.concatenate([points, between]), np.concatenate([found, residual(between)])
            stays = _stays(found, points, precision, rows)
        best = 1 if stays[1] <= stays[0] else int(np.argmin(stays))
        errors[rows] = found[best, rows]
    return errors


def _stays(residual: FloatArray, u: FloatArray, precision: FloatArray, rows: np.ndarray) -> FloatArray:
    """Misfit of the entries without ``rows`` plus the prior's (points,), for residuals (points, entries) at u."""
    kept = residual.copy()
    kept[:, rows] = 0.0
    white = kept @ precision
    away = white[:, rows]
    inside = np.linalg.solve(precision[np.ix_(rows, rows)], away.T).T
    misfit: FloatArray = np.sum(white * kept, axis=1) - np.sum(away * inside, axis=1) + np.sum(u**2, axis=1)
    return misfit


def summarise(
    fitted: HypothesisFit,
    forward: Forward,
    data: DataVector,
    cells: Cells,
    remainder: Remainder,
    log_evidence_without: tuple[float, float],
    readings: Mapping[str, float],
    rng: np.random.Generator,
) -> CandidateResult:
    """Score a fit on left-out conditions and by the absolute gate; ``readings``: held while conditions are left out."""
    _, groups = condition_groups(data)
    left = leave_out(with_readings(fitted, readings), groups)
    # a tolerance as wide as the gap would let any fit pass the check
    usual = with_readings(fitted, readings, usual=True)
    left_usual = left if fitted.usual is fitted.linearised else leave_out(usual, groups)
    null = simulate_null(usual, usual.covariance, rng, campaigns=200)
    adequate, blocks = adequacy(usual, left_usual, np.where(data.condition != "", data.block, ""), null)
    errors_left_out = left_out_errors(forward, data, fitted, left, readings)
    own, calibrated = fitted_parameters(forward, fitted)
    return CandidateResult(
        fitted.effects,
        fitted.log_evidence,
        remainder.log_evidence,
        *log_evidence_without,
        tuple(left.log_density.tolist()),
        float(cells.mean_square(errors_left_out[: data.run_entries])) if len(groups) > 1 else 0.0,
        tuple(errors_left_out.tolist()),
        tuple(fitted.residual.tolist()),
        tuple(fitted.signature.tolist()),
        adequate,
        blocks,
        own,
        calibrated,
        fitted.multipliers,
        fitted.mode.converged,
        remainder.law,
    )
