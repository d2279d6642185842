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

    def binned(self, width: int) -> Noise:
        """The noise of means over ``width`` samples."""
        count = len(self.residual) // width * width
        return Noise(self.residual[:count].reshape(-1, width).mean(axis=1), self.white_sd / np.sqrt(width))

    def autocovariance(self, lags: int) -> FloatArray:
        """Covariance of samples 0 .. lags - 1 apart [N^2], (lags,): the biased estimate, so positive definite."""
        residual = self.residual - self.residual.mean()
        size = 1 << int(np.ceil(np.log2(len(residual) + lags)))
        found = np.fft.irfft(np.abs(np.fft.rfft(residual, size)) ** 2, size)[:lags] / len(residual)
        found[0] = max(found[0], self.white_sd**2) * (1.0 + 1e-6)
        return found

    def sd(self, weights: FloatArray, count: int = 160) -> float:
        """Standard uncertainty of sum(weights * force) [weights' unit x N], from this very noise.

        What a stretch shows beyond the white noise's share counts as far as so few independent windows can show it:
        the larger of the two would be too large on average.
        """
        white = self.white_sd**2 * float(np.sum(weights**2))
        drawn = self.windows(len(weights), count) @ weights
        excess = float(np.mean(drawn**2)) / white - 1.0
        if excess <= 0.0:
            return float(np.sqrt(white))
        chance = 2.0 * len(weights) / len(self.residual)  # variance of the excess of pure white noise
        return float(np.sqrt(white * (1.0 + excess * max(0.0, 1.0 - chance / excess**2))))


def noise_of(force: FloatArray, step: float) -> Noise | None:
    """Noise of a quiet stretch: the force [N] less its slow part; ``step`` is the sample spacing [s].

    Returns None for a stretch that is too short to tell.
    """
    force = force[np.isfinite(force)]
    if len(force) < LEAST:
        return None
    width = int(max(3, min(round(TREND_WINDOW / step), len(force) // 3)))
    trend = uniform_filter1d(uniform_filter1d(force, width), width)
    residual = force - trend
    # first differences see the white part only; the median is deaf to jumps
    differences = np.diff(force)
    white = 1.4826 * float(np.median(np.abs(differences - np.median(differences)))) / np.sqrt(2.0)
    return Noise(residual, max(white, 1e-9))
