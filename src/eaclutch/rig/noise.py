"""The run's own noise, from its quiet stretches, as resampled windows and as uncertainties of linear estimators."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from eaclutch.records import FloatArray

LEAST = 400  # samples of a stretch from which noise is drawn
TREND_WINDOW = 0.1  # s, slower changes are the signal's


@dataclass(frozen=True)
class Noise:
    """Residual force of a quiet stretch, shape (samples,) [N], and the white part's sd [N]."""

    residual: FloatArray
    white_sd: float

    def windows(self, length: int, count: int) -> FloatArray:
        """``count`` windows of ``length`` samples, evenly spread over the stretch, shape (count, length) [N].

        A stretch that is too short is continued by its mirror image.
        """
        residual = self.residual
        while len(residual) < length + count:
            residual = np.concatenate([residual, residual[::-1]])
        starts = np.linspace(0, len(residual) - length, count).astype(int)
        return np.lib.stride_tricks.sliding_window_view(residual, length)[starts]

    def sd(self, weights: FloatArray, count: int = 160) -> float:
        """Standard uncertainty of sum(weights * force) [weights' unit x N], from this very noise.

        At least the white noise's share: long windows have few independent repeats in a stretch.
        """
        drawn = self.windows(len(weights), count) @ weights
        return float(max(np.sqrt(np.mean(drawn**2)), self.white_sd * np.sqrt(np.sum(weights**2))))


def noise_of(force: FloatArray, step: float) -> Noise | None:
    """Noise of a quiet stretch: the force [N] less its slow part; ``step`` is the sample spacing [s].

    Returns None for a stretch that is too short to tell.
    """
    force = force[np.isfinite(force)]
    if len(force) < LEAST:
        return None
    width = int(max(3, min(round(TREND_WINDOW / step), len(force) // 3)))
    trend = uniform_filter1d(uniform_filter1d(force, width, mode="nearest"), width, mode="nearest")
    residual = force - trend
    # first differences see the white part only; the median is deaf to jumps
    differences = np.diff(force)
    white = 1.4826 * float(np.median(np.abs(differences - np.median(differences)))) / np.sqrt(2.0)
    return Noise(residual, max(white, 1e-9))
