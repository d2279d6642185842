"""Step responses of the bare load cell: bursts of free swing give its frequency and damping ratio."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, find_peaks, sosfiltfilt

from eaclutch.records import BurstFeatures, Campaign, FloatArray, InputError
from eaclutch.rig.csv_columns import read_csv_columns
from eaclutch.rig.swing import Swing, fit_swing

HEADER = ("Time", "Load Cell", "Moving Forward")
LONGEST = 500_000  # samples
ABSURD = 1e12  # us, no record gets there
LARGEST_FORCE = 1000.0  # N, no load cell of this bench gets there
BAND = (350.0, 1200.0)  # Hz
AVERAGING = 0.002  # s of the envelope
APART = 0.2  # s between two bursts at least
STANDS_OUT = 2.0  # burst's envelope over the median one
WINDOW = (0.001, 0.022)  # s after the envelope's peak


def read_bursts(campaign: Campaign) -> BurstFeatures:
    """Frequency and damping ratio of every clear burst in the campaign's step responses, (bursts,) each."""
    swings = [swing for path in campaign.load_cell_files for swing in bursts_of(path)]

    def column(name: str) -> FloatArray:
        return np.array([getattr(swing, name) for swing in swings], dtype=float)

    return BurstFeatures(
        column("frequency"), column("frequency_sd"), column("damping_ratio"), column("damping_ratio_sd")
    )


def bursts_of(path: Path) -> list[Swing]:
    """The clear bursts of one step response. Raises InputError for a file that is none."""
    table, _ = read_csv_columns(path, HEADER, longest=LONGEST)
    table = table[(np.abs(table[:, :2]) < (ABSURD, LARGEST_FORCE)).all(axis=1)]
    if len(table) < 1000:
        raise InputError(path.name, f"{len(table)} rows are no step response", "remove the file")
    time, force = table[:, 0] * 1e-6, table[:, 1]
    step = float(np.median(np.diff(time)))
    if not 1e-5 <= step <= 4e-4 or np.mean(np.diff(time) <= 0) > 0.01:
        row = int(np.argmax(np.diff(time) <= 0)) + 3
        raise InputError(f"{path.name}, row {row}", "Time is no time in us", "check the columns' order")
    sections = butter(2, BAND, "bandpass", fs=1 / step, output="sos")
    swing = sosfiltfilt(sections, force)
    # a running mean of squares is negative by rounding behind a large value
    power = uniform_filter1d(swing**2, max(3, round(AVERAGING / step)))
    envelope = np.sqrt(np.maximum(power, 0.0))
    noise = float(np.median(np.abs(np.diff(force))) * 1.4826 / np.sqrt(2))
    peaks, _ = find_peaks(envelope, height=STANDS_OUT * np.median(envelope), distance=round(APART / step))
    found = []
    for peak in peaks:
        window = (time >= time[peak] + WINDOW[0]) & (time < time[peak] + WINDOW[1])
        # the stage's log has a pause of a millisecond at each turn: a swing is fitted on unbroken time only
        if window.sum() < 0.9 * (WINDOW[1] - WINDOW[0]) / step:
            continue
        burst = fit_swing(time[window], force[window], noise)
        if burst is not None:
            found.append(burst)
    return found
