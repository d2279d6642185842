"""What an effect would do to a campaign's entries, over the plausible range of its parameters, and how likely data are
under it: a law with its free parameters replaced by a cloud of signatures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigh
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
        projection, offset, log_det = self._projected
        scouts, _, directions = self.spread.shape
        along = (a @ projection).reshape(len(a), scouts, directions) - offset
        apart = np.sum(a**2, axis=1)[:, None] + np.sum(self.white**2, axis=1) - 2.0 * a @ self.white.T
        scores = -0.5 * (apart - np.sum(along**2, axis=2)) - log_det
        return logsumexp(scores, axis=1) - np.log(scouts)

    @cached_property
    def _projected(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What a difference from each scout is explained by: the square of its product with ``projection`` (entries,
        scouts x directions), less the scouts' own ``offset`` (scouts, directions); and half log det (scouts,)."""
        inner = np.linalg.cholesky(
            np.eye(self.spread.shape[2]) + self.spread.transpose(0, 2, 1) @ self.spread
        )
        projection = np.linalg.solve(inner, self.spread.transpose(0, 2, 1))
        offset = np.einsum("sde,se->sd", projection, self.white)
        log_det = np.sum(np.log(np.diagonal(inner, axis1=1, axis2=2)), axis=1)
        return projection.reshape(-1, self.spread.shape[1]).T, offset, log_det


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
