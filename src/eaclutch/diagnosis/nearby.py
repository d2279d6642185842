"""Whether an effect fits better a little way off from where its fit ended.

What a run does after switch-off jumps as a parameter moves: the strip lets go in this half swing or in the next. Slopes
see nothing of a jump, so a fit may end before one that it would gain by. Draws around its end do: of the effect's own
parameters, the calibrated ones following linearly.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.hypothesis import HypothesisFit
from eaclutch.diagnosis.starts import following
from eaclutch.records import FloatArray

WIDTHS = (0.3, 0.6)  # prior sds by which the draws spread
DRAWS = 64  # of each width, less one that is the end itself
WORTH_A_LOOK = 1.0  # nats that the best of them has to promise


def nearby(forward: Forward, data: DataVector, fit: HypothesisFit) -> list[FloatArray]:
    """Starts (params,) in prior coordinates beside ``fit``'s mode: the best of the draws around it where it promises
    enough over the mode, else none."""
    mode = fit.mode
    own = np.array([forward.own(name) for name in forward.priors.names])
    u = np.tile(mode.u, (1 + len(WIDTHS) * (DRAWS - 1), 1))
    drawn = ndtri(qmc.Sobol(int(own.sum()), scramble=False).random(DRAWS)[1:])
    u[1:, own] += np.concatenate([width * drawn for width in WIDTHS])
    u = np.clip(u, -5.0, 5.0)
    calibrated = mode.jacobian[:, ~own]
    w = data.values - forward.predict(forward.priors.from_normal(u)) + u[:, ~own] @ calibrated.T
    score, followers = following(
        w, calibrated, fit.linearised.covariance, 0.5 * np.sum(u[:, own] ** 2, axis=1)
    )
    best = int(np.argmax(score))
    if score[best] - score[0] < WORTH_A_LOOK:
        return []
    u[best, ~own] = np.clip(followers[best], -5.0, 5.0)
    return [u[best]]
