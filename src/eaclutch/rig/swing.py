"""A damped free swing in a force signal: frequency and damping ratio with their uncertainties."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import toeplitz
from scipy.optimize import approx_fprime, least_squares

from eaclutch.records import FloatArray

BAND = (250.0, 1500.0)  # Hz
CLEAR = 6.0  # amplitude over its standard uncertainty, below which there is no swing
SHORTEST = 20  # samples
STRAY = 1.6  # times the noise that may be left
OVER_AT_ONCE = (
    0.2  # damping ratio beyond which the force is gone within a turn: friction stopped it, no free swing
)


@dataclass(frozen=True)
class Swing:
    """Natural frequency [Hz], damping ratio, amplitude [N] at the window's start; standard uncertainties."""

    frequency: float
    frequency_sd: float
    damping_ratio: float
    damping_ratio_sd: float
    amplitude: float


def fit_swing(
    time: FloatArray, force: FloatArray, noise_sd: float, autocovariance: FloatArray | None = None
) -> Swing | None:
    """Least squares of level + line + exp(-zeta w t) (a cos(w_d t) + b sin(w_d t)); None where none stands out.

    ``time`` [s] and ``force`` [N] have shape (samples,), ``noise_sd`` [N] is one sample's; ``autocovariance`` [N^2]
    of noise 0, 1, ... samples apart, (samples,), where it is not white: a vibration line near the swing moves its
    frequency more than white noise does. The frequency is the undamped one, w / 2 pi with w_d = w sqrt(1 - zeta^2).
    """
    t = time - time[0]
    span = t[-1]
    if len(t) < SHORTEST or not (span > 0 and noise_sd > 0):
        return None

    def design(w: float, zeta: float) -> FloatArray:
        return np.stack([np.ones_like(t), t / span - 0.5, *_damped(t, w, zeta)], axis=1)

    def residual(p: FloatArray) -> FloatArray:
        basis = design(p[0], p[1])
        return (force - basis @ np.linalg.lstsq(basis, force, rcond=None)[0]) / noise_sd

    grid = 2 * np.pi * np.arange(BAND[0], BAND[1], 0.35 / span)
    cost = [np.sum(residual(np.array([w, 0.03])) ** 2) for w in grid]
    start = np.array([grid[int(np.argmin(cost))], 0.03])
    low, high = np.array([0.9 * 2 * np.pi * BAND[0], 1e-4]), np.array([1.1 * 2 * np.pi * BAND[1], 0.5])
    fit = least_squares(residual, start, bounds=(low, high), x_scale=(10.0, 0.01))
    w, zeta = fit.x
    basis = design(w, zeta)
    weights = np.linalg.lstsq(basis, force, rcond=None)[0]
    amplitude = float(np.hypot(weights[2], weights[3]))
    left = float(np.sqrt(np.mean(fit.fun**2) * len(t) / (len(t) - 6)))
    amplitude_sd = noise_sd * float(np.sqrt(np.linalg.pinv(basis.T @ basis)[2, 2]))
    unclear = amplitude < CLEAR * amplitude_sd * max(1.0, left) or left > STRAY
    if unclear or zeta > OVER_AT_ONCE or not BAND[0] <= w / (2 * np.pi) <= BAND[1]:
        return None
    lever = _levers(t, force, np.array([w, zeta, *weights]))
    if autocovariance is None:
        variance = np.sum(lever**2, axis=0) * (noise_sd * max(1.0, left)) ** 2
    else:
        variance = np.diag(lever.T @ toeplitz(autocovariance) @ lever)
    sd = np.sqrt(variance)
    return Swing(w / (2 * np.pi), sd[0] / (2 * np.pi), float(zeta), float(sd[1]), amplitude)


def _damped(t: FloatArray, w: float, zeta: float) -> tuple[FloatArray, FloatArray]:
    """exp(-zeta w t) cos(w_d t) and the same with the sine, (samples,)."""
    decay, wd = np.exp(-zeta * w * t), w * np.sqrt(max(1e-9, 1.0 - zeta**2))
    return decay * np.cos(wd * t), decay * np.sin(wd * t)


def _levers(t: FloatArray, force: FloatArray, found: FloatArray) -> FloatArray:
    """How frequency [rad/s] and damping ratio of a fit move with each sample's force [1/N], shape (samples, 2).

    ``found`` is w, zeta, level, line, a, b. Friction ends a swing otherwise than exponentially, and where a fit leaves
    that much the second derivatives of the swing count beside the slopes: the whole Hessian of the squares is
    inverted, not the slopes' product.
    """

    def slopes_and_left(p: FloatArray) -> tuple[FloatArray, FloatArray]:
        w, zeta, level, line, a, b = p
        cos, sin = _damped(t, w, zeta)
        q = np.sqrt(max(1e-9, 1.0 - zeta**2))
        swing, turned = a * cos + b * sin, b * cos - a * sin
        by_w, by_zeta = t * (q * turned - zeta * swing), -w * t * (swing + zeta / q * turned)
        slopes = np.stack([by_w, by_zeta, np.ones_like(t), t / t[-1] - 0.5, cos, sin], axis=1)
        return slopes, level + line * slopes[:, 3] + swing - force

    def gradient(p: FloatArray) -> FloatArray:
        slopes, left = slopes_and_left(p)
        return np.asarray(slopes.T @ left)

    steps = 1e-6 * np.array([found[0], 1.0, *[max(1e-6, float(np.ptp(force)))] * 4])
    hessian = np.asarray(approx_fprime(found, gradient, steps))
    return np.asarray(slopes_and_left(found)[0] @ np.linalg.pinv(0.5 * (hessian + hessian.T)))[:, :2]
