"""Whether an effect fits better a little way off from where its fit ended.

What a run does after switch-off jumps as a parameter moves: the strip lets go in this half swing or in the next. Slopes
see nothing of a jump, so a fit may end before one that it would gain by. Draws around its end do: of the effect's own
parameters, the calibrated ones following linearly.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtri
from scipy.stats import qmc

from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.records import FloatArray

WIDTHS = (0.3, 0.6)  # prior sds by which the draws spread
DRAWS = 64  # of each width, less one that is the end itself


def nearby(forward: Forward, data: DataVector, fit: HypothesisFit) -> tuple[FloatArray, float]:
    """The best of the draws around ``fit``'s mode, (params,) in prior coordinates, and the nats that it promises over
    the mode, 0 where none does."""
    mode = fit.mode
    own = np.array([forward.own(name) for name in forward.priors.names])
    u = np.tile(mode.u, (1 + len(WIDTHS) * (DRAWS - 1), 1))
    drawn = ndtri(qmc.Sobol(int(own.sum()), scramble=False).random(DRAWS)[1:])
    u[1:, own] += np.concatenate([width * drawn for width in WIDTHS])
    u = np.clip(u, -5.0, 5.0)
    follows = mode.jacobian[:, ~own]
    predicted = forward.predict(forward.priors.from_normal(u))
    w = data.values - predicted + u[:, ~own] @ follows.T
    white = cho_solve(cho_factor(fit.linearised.covariance + follows @ follows.T, lower=True), w.T)
    score = -0.5 * np.sum(w.T * white, axis=0) - 0.5 * np.sum(u[:, own] ** 2, axis=1)
    best = int(np.argmax(score))
    start = u[best].copy()
    start[~own] = np.clip(follows.T @ white[:, best], -5.0, 5.0)
    return start, float(score[best] - score[0])
