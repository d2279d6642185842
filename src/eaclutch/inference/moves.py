"""Moves of the ensemble sampler: differential evolution, stretch, jumps to a fixed Student t, and redraws.

The t is fitted to an ensemble's own warm-up and stays fixed afterwards, so jumps keep the posterior exactly. In the
priors' normal coordinates most posteriors are nearly Gaussian, and jumps cut the autocorrelation time from about 25
steps to about 5. A parameter of several modes is drawn anew from its prior as well, which takes a walker from mode to
mode. No snooker move: in emcee 3.1.6 it leaves a Gaussian's sd 25 % too small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from emcee.moves import DEMove, MHMove, StretchMove

from eaclutch.records import FloatArray

DEGREES_OF_FREEDOM = 6.0  # tails heavier than the target's keep the acceptance from vanishing anywhere
WIDENING = 1.1
REDRAWS = 0.5  # for each step of the other moves together


@dataclass(frozen=True)
class Target:
    """Centre (params,) and lower Cholesky root (params, params) of the Student t that walkers jump to.

    Products go through einsum: for such small arrays a threaded BLAS costs a hundred times the work itself.
    """

    centre: FloatArray
    root: FloatArray
    _inverse: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_inverse", np.linalg.inv(self.root))

    @classmethod
    def of(cls, points: FloatArray) -> Target:
        """Fitted to points (points, params)."""
        covariance = np.atleast_2d(np.cov(points.T)) + 1e-12 * np.eye(points.shape[1])
        return cls(points.mean(axis=0), np.asarray(WIDENING * np.linalg.cholesky(covariance)))

    def log_density(self, u: FloatArray) -> FloatArray:
        """Up to a constant, (points,)."""
        white = np.einsum("ij,wj->wi", self._inverse, u - self.centre)
        size = u.shape[1]
        return -0.5 * (DEGREES_OF_FREEDOM + size) * np.log1p(np.sum(white**2, axis=1) / DEGREES_OF_FREEDOM)

    def jump(self, u: FloatArray, random: np.random.RandomState) -> tuple[FloatArray, FloatArray]:
        """Proposals (walkers, params) that do not depend on u, and ln q(u) - ln q(proposal)."""
        scale = np.sqrt(DEGREES_OF_FREEDOM / random.chisquare(DEGREES_OF_FREEDOM, len(u)))
        white = scale[:, None] * random.standard_normal(u.shape)
        proposal = self.centre + np.einsum("ij,wj->wi", self.root, white)
        return proposal, self.log_density(u) - self.log_density(proposal)


@dataclass(frozen=True)
class Redraw:
    """One of the parameters ``which`` (indices), drawn anew from its prior, the standard normal; the others stay."""

    which: tuple[int, ...]

    def jump(self, u: FloatArray, random: np.random.RandomState) -> tuple[FloatArray, FloatArray]:
        """Proposals (walkers, params), and ln q(u | proposal) - ln q(proposal | u)."""
        walkers, proposal = np.arange(len(u)), u.copy()
        one = np.array(self.which)[random.randint(len(self.which), size=len(u))]
        proposal[walkers, one] = random.standard_normal(len(u))
        return proposal, 0.5 * (proposal[walkers, one] ** 2 - u[walkers, one] ** 2)


def moves(target: Target, redrawn: Sequence[int] = ()) -> list[tuple[object, float]]:
    """The mixture with which an ensemble is sampled; ``redrawn``: indices of parameters of several modes."""
    mixture = [(DEMove(), 0.4), (StretchMove(), 0.1), (MHMove(target.jump), 0.5)]
    return [*mixture, (MHMove(Redraw(tuple(redrawn)).jump), REDRAWS)] if redrawn else mixture
