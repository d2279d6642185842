"""The generator's own reading of a run: the contract's observables from noisy samples, with uncertainties."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.signal import savgol_filter

from eaclutch.blind.readout import SAMPLE_STEP, WHITE_SD
from eaclutch.records import FloatArray

OBSERVABLES = (
    "friction_before_n",
    "engagement_time_s",
    "ramp_rate_n_s",
    "ramp_rate_early_n_s",
    "ramp_rate_late_n_s",
    "shear_capacity_n",
    "switch_off_force_n",
    "start_ratio",
    "slip_fraction",
    "hold_creep_n_s",
    "release_time_10_s",
    "release_time_50_s",
    "release_time_90_s",
    "ringdown_frequency_hz",
    "ringdown_damping_ratio",
    "final_force_n",
    "baseline_shift_n",
)
ZERO_SD = 0.0015  # N, how well a zero is read off a run that shows it
EDGE_SD = SAMPLE_STEP / np.sqrt(12)  # s, where between two samples the voltage fell


def _slope(time: FloatArray, force: FloatArray, sd: float) -> tuple[float, float]:
    centred = time - time.mean()
    spread = np.sum(centred**2)
    return float(centred @ force / spread), float(sd / np.sqrt(spread))


def read_run(
    time: FloatArray, force: FloatArray, on: float, off: float, dwell: float, zero: float, zero_sd: float
) -> dict[str, tuple[float, float]]:
    """Observables of one run: {name: (value, sd)}, NaN where there is nothing to read.

    ``on``, ``off``: as the log shows them (on a sample; off between two); ``zero`` is taken off.
    """
    force = force - zero
    sd = WHITE_SD * 1.08

    def window(a: float, b: float) -> slice:
        return slice(int(np.searchsorted(time, a)), int(np.searchsorted(time, b)))

    out: dict[str, tuple[float, float]] = dict.fromkeys(OBSERVABLES, (np.nan, np.nan))
    early = window(on - 0.5, on)
    before = float(force[early].mean())
    before_sd = float(np.hypot(sd / np.sqrt(0.5 / SAMPLE_STEP / 4), zero_sd))
    just = float(force[window(on - 0.02, on)].mean())
    just_sd = sd / np.sqrt(0.02 / SAMPLE_STEP / 2)
    out["friction_before_n"] = (before, before_sd)
    for name, a, b in (("", 0.002, 0.02), ("_early", 0.0005, 0.005), ("_late", 0.05, 0.2)):
        part = window(on + a, on + b)
        out[f"ramp_rate{name}_n_s"] = _slope(time[part], force[part], sd)
    out["engagement_time_s"] = _onset(time, force, on, just, just_sd, sd)
    driven = window(on, off)
    smooth = np.convolve(force[driven], np.full(20, 0.05), "valid")
    top = float(smooth.max())
    top_sd = sd / np.sqrt(20)
    out["shear_capacity_n"] = (top - just, float(np.hypot(top_sd, just_sd)))
    level = float(np.median(force[window(off - 0.003, off)]))
    level_sd = 1.25 * sd / np.sqrt(0.003 / SAMPLE_STEP)
    out["switch_off_force_n"] = (level, float(np.hypot(level_sd, zero_sd)))
    final = float(force[window(off + 0.01, off + 0.11)].mean())
    final_sd = sd / np.sqrt(0.1 / SAMPLE_STEP / 3)
    out["final_force_n"] = (final, float(np.hypot(final_sd, zero_sd)))
    out["baseline_shift_n"] = (final - before, float(np.hypot(final_sd, sd / np.sqrt(1600))))
    swing = top - final
    if swing > 0.03:
        ratio = (level - final) / swing
        out["start_ratio"] = (ratio, float(np.hypot(level_sd, ratio * top_sd) / swing))
    if dwell >= 0.3:
        rest = window(off - 0.3, off)
        out["hold_creep_n_s"] = _slope(time[rest], force[rest], sd)
    out["slip_fraction"] = _largest_slip(force[driven], sd)
    out |= _release(time, force, off, level, level_sd, final, final_sd, sd)
    return out


def _largest_slip(force: FloatArray, sd: float) -> tuple[float, float]:
    """Largest slip as a share of the force before it, from straight lines before and after it; NaN without."""
    short = np.convolve(force, np.full(5, 0.2), "same")
    drop = short[:-14] - short[14:]
    reach = 26
    place = int(np.argmax(drop[reach : -reach - 40])) + reach
    if drop[place] < 7 * sd * np.sqrt(0.4):
        return np.nan, np.nan
    peak = place - 4 + int(np.argmax(short[place - 4 : place + 8]))
    trough = peak + int(np.argmin(short[peak : peak + 20]))
    count = np.arange(reach)
    before = np.polyval(np.polyfit(count - reach, force[peak - reach : peak], 1), 0.0)
    after = np.polyval(np.polyfit(count + 1, force[trough + 1 : trough + 1 + reach], 1), 0.0)
    line_sd = 2 * sd / np.sqrt(reach)
    height = float(before)
    if height < 7 * line_sd:  # the zero, or the force, is too small to take shares of
        return np.nan, np.nan
    share = float((before - after) / height)
    return share, float(np.hypot(line_sd, line_sd * (1 - share)) / height)


def _onset(
    time: FloatArray, force: FloatArray, on: float, level: float, level_sd: float, sd: float
) -> tuple[float, float]:
    """Where a straight line through the first 8 ms meets the level before; (NaN, NaN) without a clear rise."""
    part = slice(int(np.searchsorted(time, on + 0.0005)), int(np.searchsorted(time, on + 0.008)))
    slope, slope_sd = _slope(time[part], force[part], sd)
    if slope < 6 * slope_sd:
        return np.nan, np.nan
    centre, height = float(time[part].mean()), float(force[part].mean()) - level
    onset = centre - height / slope - on
    height_sd = np.hypot(sd / np.sqrt(part.stop - part.start), level_sd)
    return onset, float(np.hypot(height_sd, height / slope * slope_sd) / slope) + 2e-4


def _release(
    time: FloatArray,
    force: FloatArray,
    off: float,
    level: float,
    level_sd: float,
    final: float,
    final_sd: float,
    sd: float,
) -> dict[str, tuple[float, float]]:
    """Release times from a local parabola of seven samples, and the swing from its turning points."""
    out: dict[str, tuple[float, float]] = {}
    drop = level - final
    if drop < 4 * sd:
        return out
    start = int(np.searchsorted(time, off))
    piece = force[start - 12 : start + 400].copy()
    piece[:12] = level
    half = 2 if drop > 0.3 else 3
    smooth = savgol_filter(piece, 2 * half + 1, 2)[12 - half :]
    clock = time[start - half : start + 400] - off
    for share in (0.1, 0.5, 0.9):
        threshold = level - share * drop
        below = np.nonzero((smooth < threshold) & (clock > 0))[0]
        if len(below) == 0:
            continue
        i = below[0]
        high, low = smooth[i - 1], smooth[i]
        part = (high - threshold) / (high - low) if high > threshold else 1.0
        value = clock[i - 1] + part * (clock[i] - clock[i - 1])
        steep = max((high - low) / SAMPLE_STEP, drop / 2e-3)
        edge = np.hypot(level_sd * (1 - share), final_sd * share)
        noise = np.hypot(sd * np.sqrt(0.4), edge) / steep
        out[f"release_time_{share * 100:g}_s"] = (float(max(value, 0.0)), float(np.hypot(noise, EDGE_SD)))
    late = slice(int(np.searchsorted(time, off + 0.004)), int(np.searchsorted(time, off + 0.014)))
    rest, beat = force[late] - final, time[late]
    if rest.std() > 1.8 * sd:
        rest = savgol_filter(rest, 5, 2)
        ups = np.nonzero((rest[:-1] < 0) & (rest[1:] >= 0))[0]
        if len(ups) >= 3:
            cross = beat[ups] - rest[ups] * SAMPLE_STEP / (rest[ups + 1] - rest[ups])
            period = (cross[-1] - cross[0]) / (len(cross) - 1)
            peaks = np.array([rest[a:b].max() for a, b in itertools.pairwise(ups)])
            if np.all(np.diff(cross) < 1.3 * period) and peaks[-1] > 2 * sd:
                turns = len(peaks) - 1
                decrement = np.log(peaks[0] / peaks[-1]) / (2 * np.pi * turns)
                period_sd = 0.5 * sd / peaks[-1] / (2 * np.pi) * np.sqrt(2) / turns
                out["ringdown_frequency_hz"] = (float(1 / period), float(period_sd / period))
                damping_sd = 0.6 * sd / peaks[-1] / (2 * np.pi * turns)
                out["ringdown_damping_ratio"] = (float(decrement), float(damping_sd))
    return out
