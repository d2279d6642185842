"""Which samples of a column still stand where the time column says, after the link has lost lines.

A column that lost lines slides left from the hole on and ends in exact zeros, as many as lines were lost. The lines
may be lost in one place or in several (blocks of some hundred). What can be known for certain is the shift before
the first hole (0) and after the last (all of it); events in the force tell which of the two holds around them.
"""

from __future__ import annotations

import numpy as np

from eaclutch.records import FloatArray

GAP = 2.5  # sample spacings: time between two samples that is none of sampling
STUCK = 200  # samples of one and the same force
COARSE = 0.1  # of the samples that read zero as they pass through: more would make the tail longer than what was lost
FEWEST = 8  # zeros at the end that chance does not make


def sample_spacing(time: FloatArray, span: int = 64) -> float:
    """Usual time between two samples [s], NaN if unknown: stamps are whole microseconds, so over ``span`` samples."""
    spans = time[span:] - time[:-span]
    spans = spans[np.isfinite(spans)]
    return float(np.median(spans)) / span if len(spans) else float("nan")


def lost_lines(values: FloatArray) -> int:
    """How many lines a column of shape (samples,) lost: exact zeros at its end, 0 where those are its own.

    A column that reads exactly zero elsewhere at rest (a simulated one may) keeps its zeros; one that passes through
    zero, counted coarsely, reads it for a few samples at a time.
    """
    nonzero = np.flatnonzero(values != 0)
    if len(nonzero) == 0:
        return 0
    tail = len(values) - 1 - int(nonzero[-1])
    if tail < FEWEST:
        return 0
    body = values[: nonzero[-1] + 1]
    share = np.mean(body == 0)
    coarse = share < COARSE and _longest(body == 0) < min(STUCK, tail / 2)
    return tail if share < 0.01 or coarse else 0


def _longest(true: np.ndarray) -> int:
    """How many samples in a row are ``true`` (samples,) at most."""
    breaks = np.flatnonzero(np.concatenate([[True], ~true, [True]]))
    return int(np.diff(breaks).max()) - 1


def moved_right(values: FloatArray, start: int, lost: int) -> FloatArray:
    """The column with everything from ``start`` on moved ``lost`` samples right; the hole is NaN."""
    out = values.copy()
    out[start + lost :] = values[start : len(values) - lost]
    out[start : start + lost] = np.nan
    return out


def unbroken_time(time: FloatArray) -> tuple[FloatArray, tuple[str, ...]]:
    """The time column (samples,) [s] made whole where that is certain, and flags saying what was done.

    A tail of zeros as long as the jumps before it: each part is moved back to its place and the holes filled at the
    even spacing of the sampling (``time_realigned``). Single stamps out of line (``time_repaired``) lie between
    their neighbours. What is left out of order is flagged ``time_broken``.
    """
    flags = []
    step = sample_spacing(time)
    if not step > 0:
        return time, ("time_broken",)
    lost = len(time) - 1 - int(np.flatnonzero(time > 0)[-1]) if (time > 0).any() else 0
    if lost:
        body = time[: len(time) - lost]
        missing = np.nan_to_num(np.round(np.diff(body) / step) - 1, posinf=0, neginf=0).astype(int)
        holes = np.flatnonzero(missing >= FEWEST)
        if lost == missing[holes].sum():
            place = np.arange(len(body)) + np.concatenate(
                [[0], np.cumsum(np.where(missing >= FEWEST, missing, 0))]
            )
            time = np.interp(np.arange(len(time)), place, body)
            flags.append("time_realigned")
    stamps = np.arange(len(time))
    good = np.isfinite(time)
    # a stamp that lost a digit is far from the line through its neighbours
    inner = time[1:-1] - 0.5 * (time[:-2] + time[2:])
    neighbours = np.abs(time[2:] - time[:-2] - 2 * step) < step
    good[1:-1] &= ~(neighbours & (np.abs(inner) > 0.6 * step))
    if not good.all() and good.sum() > 2:
        time = np.interp(stamps, stamps[good], time[good])
        flags.append("time_repaired")
    if not (np.diff(time) > 0).all():
        flags.append("time_broken")
    elif (np.diff(time) > GAP * step).any():
        flags.append("time_gap")
    return time, tuple(flags)


def stuck(force: FloatArray) -> bool:
    """Whether a force (samples,) repeats one value for longer than a live load cell's noise lets it."""
    changes = np.flatnonzero(np.diff(force) != 0)
    edges = np.concatenate([[-1], changes, [len(force) - 1]])
    return bool(np.diff(edges).max() > STUCK)


def without_glitches(force: FloatArray, least: float = 0.1) -> tuple[FloatArray, tuple[str, ...]]:
    """The force (samples,) [N] with single samples that cannot be replaced by the mean of their neighbours.

    A number that lost its first character stands far (10 standard deviations and ``least``) from neighbours that
    agree with each other; a NaN is a sample that was not logged.
    """
    flags = []
    out = force.copy()
    missing = ~np.isfinite(out)
    if missing.any() and not missing.all():
        flags.append("force_missing")
        out[missing] = np.interp(np.flatnonzero(missing), np.flatnonzero(~missing), out[~missing])
    differences = np.diff(out)
    noise = 1.4826 * float(np.median(np.abs(differences - np.median(differences)))) / np.sqrt(2.0)
    middle = 0.5 * (out[:-2] + out[2:])
    away = np.abs(out[1:-1] - middle)
    glitch = (away > max(10.0 * noise, least)) & (np.abs(out[2:] - out[:-2]) < 0.4 * away)
    if glitch.any():
        flags.append("force_glitch")
        out[1:-1][glitch] = middle[glitch]
    return out, tuple(flags)
