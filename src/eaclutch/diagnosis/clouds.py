"""What an effect would do to a campaign's entries, over the plausible range of its parameters, and how likely data are
under it: a law with its free parameters replaced by a cloud of signatures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh
from scipy.spatial.distance import cdist
from scipy.special import logsumexp

from eaclutch.records import FloatArray

AMPLITUDES = (0.5, 1.0, 2.0)  # that each scouted signature stands for
AMPLITUDE_SD = 0.3  # and for its neighbours of other amplitude, too
LAW_DIRECTIONS = 12  # in which an effect's own law may be off, the widest ones
NEIGHBOURS = 4  # towards which each scouted signature stands for what lies between
BETWEEN = 0.5  # of the way there, sd


@dataclass(frozen=True)
class Cloud:
    """Signatures of one law, whitened by the base model's marginal covariance: ``white`` (scouts, entries), and how
    each may differ from the truth, in amplitude, in its law and towards its neighbours: ``spread`` (scouts, entries,
    directions)."""

    white: FloatArray
    spread: FloatArray

    def evidence(self, a: FloatArray) -> FloatArray:
        """Log mean over scouts b of N(a; b, 1 + D D'), D its spread, of whitened data ``a`` (sets, entries), up to the
        constant that all clouds share."""
        scores = np.empty((len(self.white), len(a)))
        for i, (b, spread) in enumerate(zip(self.white, self.spread, strict=True)):
            difference = a - b
            inner = cho_factor(np.eye(spread.shape[1]) + spread.T @ spread, lower=True)
            along = difference @ spread
            explained = np.sum(along.T * cho_solve(inner, along.T), axis=0)
            log_det = np.sum(np.log(np.diag(inner[0])))
            scores[i] = -0.5 * (np.sum(difference**2, axis=1) - explained) - log_det
        return logsumexp(scores, axis=0) - np.log(len(scores))


def cloud_of(
    shifts: FloatArray, law_share: float, whiten: Callable[[FloatArray], FloatArray], smooth: FloatArray
) -> Cloud:
    """The cloud around signatures ``shifts`` (scouts, entries) of a law that may be off by ``law_share`` of each,
    smoothly over the settings (``smooth``, (entries, entries)); ``whiten``: of rows, (rows, entries)."""
    white = whiten(shifts)
    spread = np.zeros((*white.shape, LAW_DIRECTIONS + 1 + NEIGHBOURS))
    apart = cdist(white, white)
    for i, shift in enumerate(law_share * shifts):
        half = whiten(smooth * np.outer(shift, shift))
        values, vectors = eigh(whiten(half.T), subset_by_index=[len(shift) - LAW_DIRECTIONS, len(shift) - 1])
        spread[i, :, 1 : LAW_DIRECTIONS + 1] = vectors * np.sqrt(np.maximum(values, 0.0))
        nearest = np.argsort(apart[i])[1 : NEIGHBOURS + 1]
        spread[i, :, LAW_DIRECTIONS + 1 :][:, : len(nearest)] = BETWEEN * (white[nearest] - white[i]).T
    spread[:, :, 0] = AMPLITUDE_SD * white
    scaled = [(a * white, a * spread) for a in AMPLITUDES]
    return Cloud(np.concatenate([w for w, _ in scaled]), np.concatenate([d for _, d in scaled]))
