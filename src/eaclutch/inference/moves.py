"""Moves of the ensemble sampler: differential evolution, stretch, jumps to a fixed Student t, and redraws.

The t is fitted to an ensemble's own warm-up and stays fixed afterwards, so jumps keep the posterior exactly. In the
priors' normal coordinates most posteriors are nearly Gaussian, and jumps cut the autocorrelation time from about 25
steps to about 5. A parameter of several modes is drawn anew by itself, which takes a walker from mode to mode, and
is held where it is when the others jump: no t fits its modes, and a jump that moves it as well is hardly ever accepted.
No snooker move: in emcee 3.1.6 it leaves a Gaussian's sd 25 % too small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from emcee.moves import DEMove, MHMove, RedBlueMove, StretchMove
from scipy.special import logsumexp

from eaclutch.records import FloatArray

DEGREES_OF_FREEDOM = 6.0  # tails heavier than the target's keep the acceptance from vanishing anywhere
WIDENING = 1.1
JUMPS = 0.5  # of the whole, where nothing is redrawn
# in the jumps' place where something is: half of the whole, and a quarter
HELD = 1.0
REDRAWS = 0.5
SMOOTHING = 0.1  # of the spread of the other half, for a redraw near one of them
NARROWEST = 1e-9  # where they do not spread at all


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

    def over(self, which: Sequence[int]) -> Target:
        """The marginal of the parameters ``which`` (indices)."""
        pick = np.array(which)
        covariance = np.einsum("ij,kj->ik", self.root[pick], self.root[pick])
        return Target(self.centre[pick], np.linalg.cholesky(covariance))


@dataclass(frozen=True)
class Held:
    """A jump of the parameters ``which`` (indices) to their ``target``; the others stay."""

    which: tuple[int, ...]
    target: Target

    def jump(self, u: FloatArray, random: np.random.RandomState) -> tuple[FloatArray, FloatArray]:
        """Proposals (walkers, params), and ln q(u | proposal) - ln q(proposal | u)."""
        proposal = u.copy()
        proposal[:, self.which], log_ratio = self.target.jump(u[:, self.which], random)
        return proposal, log_ratio


class Redraw(RedBlueMove):
    """One of the parameters ``which`` (indices) drawn anew, from its prior, the standard normal, or from near where a
    walker of the other half of the ensemble has it; the other parameters stay."""

    def __init__(self, which: Sequence[int]) -> None:
        super().__init__()
        self.which = np.array(which)

    def get_proposal(
        self, walkers: FloatArray, others: Sequence[FloatArray], random: np.random.RandomState
    ) -> tuple[FloatArray, FloatArray]:
        """Proposals (walkers, params), and ln q(u | proposal) - ln q(proposal | u)."""
        rows, proposal, near = np.arange(len(walkers)), walkers.copy(), np.concatenate(others)
        one = self.which[random.randint(len(self.which), size=len(walkers))]
        around = near[:, one]  # (others, walkers)
        width = SMOOTHING * around.std(axis=0) + NARROWEST
        drawn, chosen = random.standard_normal(len(walkers)), random.randint(len(near), size=len(walkers))
        drawn = np.where(
            random.random_sample(len(walkers)) < 0.5, drawn, around[chosen, rows] + width * drawn
        )
        proposal[rows, one] = drawn

        def log_density(u: FloatArray) -> FloatArray:  # up to a constant
            nearby = logsumexp(-0.5 * ((u - around) / width) ** 2, axis=0, b=1.0 / (len(near) * width))
            return np.logaddexp(-0.5 * u**2, nearby)

        return proposal, log_density(walkers[rows, one]) - log_density(drawn)


def moves(target: Target, redrawn: Sequence[int] = ()) -> list[tuple[object, float]]:
    """The mixture with which an ensemble is sampled; ``redrawn``: indices of parameters of several modes."""
    mixture: list[tuple[object, float]] = [(DEMove(), 0.4), (StretchMove(), 0.1)]
    if not redrawn:
        return [*mixture, (MHMove(target.jump), JUMPS)]
    others = tuple(i for i in range(len(target.centre)) if i not in redrawn)
    held = [(MHMove(Held(others, target.over(others)).jump), HELD)] if others else []
    return [*mixture, *held, (Redraw(redrawn), REDRAWS)]
