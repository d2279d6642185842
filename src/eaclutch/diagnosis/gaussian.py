"""Closed forms of the linearised model: evidence, refits without a condition, and their predictions.

Near a fit the data vector is y = m + J (u - u_mode) + e with u ~ N(0, 1), e ~ N(0, C). So
w = y - m + J u_mode is Gaussian with covariance S = C + J J', and everything that a refit without some
entries would give follows from the inverse of S.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from eaclutch.records import FloatArray


@dataclass(frozen=True)
class Linearised:
    """A fit as a Gaussian: ``w`` (entries,), ``jacobian`` (entries, params) and ``covariance`` C."""

    w: FloatArray
    jacobian: FloatArray
    covariance: FloatArray

    def marginal(self) -> FloatArray:
        """S, covariance of ``w`` with the parameters' prior in it, (entries, entries)."""
        return self.covariance + self.jacobian @ self.jacobian.T


def posterior_mean(fit: Linearised) -> FloatArray:
    """Parameters (params,) where all the data put them."""
    mean: FloatArray = fit.jacobian.T @ np.linalg.solve(fit.marginal(), fit.w)
    return mean


def posterior_sd(fit: Linearised) -> FloatArray:
    """How well all the data know the parameters (params,), in prior sds."""
    explained = np.sum(fit.jacobian * np.linalg.solve(fit.marginal(), fit.jacobian), axis=0)
    return np.sqrt(np.maximum(1.0 - explained, 0.0))


def given(fit: Linearised, known: Mapping[int, float]) -> Linearised:
    """The fit with some parameters held: {index: value in prior coordinates}."""
    if not known:
        return fit
    held = np.array(list(known), dtype=int)
    rest = np.setdiff1d(np.arange(fit.jacobian.shape[1]), held)
    values = np.array(list(known.values()), dtype=float)
    return Linearised(fit.w - fit.jacobian[:, held] @ values, fit.jacobian[:, rest], fit.covariance)


def log_normal(w: FloatArray, covariance: FloatArray) -> float:
    """log N(w; 0, covariance)."""
    factor = cho_factor(covariance, lower=True)
    half_log_det = float(np.sum(np.log(np.diag(factor[0]))))
    return -0.5 * float(w @ cho_solve(factor, w)) - half_log_det - 0.5 * len(w) * np.log(2 * np.pi)


@dataclass(frozen=True)
class LeaveOut:
    """Refits without each group of entries, as linear maps on ``w``.

    groups: the entries of each group. log_density (groups,): of what was measured there, given the others.
    prediction_error (entries, entries): maps w to measured less the refitted model's own prediction, without
    help from smooth terms. conditional (entries, entries): maps w to the residual after the smooth terms were
    carried over as well. u (groups, params): the refits' parameters.
    """

    groups: tuple[np.ndarray, ...]
    log_density: FloatArray
    prediction_error: FloatArray
    conditional: FloatArray
    u: FloatArray


def leave_out(fit: Linearised, groups: Sequence[np.ndarray]) -> LeaveOut:
    """Leave out each group of entries in turn (Sundararajan & Keerthi 2001, doi:10.1162/08997660151134343).

    Rows of the maps that belong to no group are zero.
    """
    inverse = np.linalg.inv(fit.marginal())
    inverse = 0.5 * (inverse + inverse.T)
    gain = inverse @ fit.jacobian
    size = len(fit.w)
    prediction, conditional = np.zeros((size, size)), np.zeros((size, size))
    densities, refits = [], []
    for rows in groups:
        precision = inverse[np.ix_(rows, rows)]
        # error of the prediction of these entries from all the others, as a map on w
        error = np.linalg.solve(precision, inverse[rows])
        value = error @ fit.w
        sign, log_det = np.linalg.slogdet(precision)
        if sign <= 0:
            raise FloatingPointError("the covariance of the data vector is not positive definite")
        densities.append(
            -0.5 * value @ precision @ value + 0.5 * log_det - 0.5 * len(rows) * np.log(2 * np.pi)
        )
        # posterior mean without the rows: J_k' S_kk^-1 w_k = J' S^-1 (w - E error)
        u_map = gain.T - gain[rows].T @ error
        conditional[rows] = error
        prediction[rows] = -fit.jacobian[rows] @ u_map
        prediction[rows, rows] += 1.0
        refits.append(u_map @ fit.w)
    return LeaveOut(tuple(groups), np.array(densities), prediction, conditional, np.array(refits))
