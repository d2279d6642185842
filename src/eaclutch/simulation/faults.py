"""What goes wrong on the rig's serial link, put into a recording on purpose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from eaclutch.records import FloatArray, InputError, Recording

FAULTS = ("force_shift", "voltage_shift", "time_tail", "not_a_number", "lost_character", "extra_samples")


def damage(
    recording: Recording, rates: Mapping[str, float], rng: np.random.Generator
) -> tuple[Recording, list[str]]:
    """A recording with the link's faults, each present with its rate (0 .. 1); returns what was done, too.

    Raises InputError for a fault that is not in ``FAULTS``.
    """
    unknown = sorted(set(rates) - set(FAULTS))
    if unknown:
        raise InputError(
            f"faults.{unknown[0]}", "is not a fault of the link", f"use one of {', '.join(FAULTS)}"
        )
    done = []
    for fault in FAULTS:
        if rng.random() < rates.get(fault, 0.0):
            recording = _ACTIONS[fault](recording, rng)
            done.append(fault)
    return recording, done


def lose_lines(column: FloatArray, at: int, count: int) -> FloatArray:
    """The column (samples,) after ``count`` lines were lost at ``at``: the rest slides up, zeros end it."""
    return np.concatenate([column[:at], column[at + count :], np.zeros(count)])


def _lost(column: FloatArray, rng: np.random.Generator) -> FloatArray:
    count = int(np.exp(rng.uniform(np.log(50), np.log(min(9000, len(column) // 4)))))
    return lose_lines(column, int(rng.integers(len(column) - count)), count)


def _force_shift(recording: Recording, rng: np.random.Generator) -> Recording:
    return replace(recording, force=_lost(recording.force, rng))


def _voltage_shift(recording: Recording, rng: np.random.Generator) -> Recording:
    return replace(recording, voltage=_lost(recording.voltage, rng))


def _time_tail(recording: Recording, rng: np.random.Generator) -> Recording:
    count = int(rng.integers(12, 40))
    return replace(
        recording, time=lose_lines(recording.time, int(rng.integers(len(recording.time) // 2)), count)
    )


def _not_a_number(recording: Recording, rng: np.random.Generator) -> Recording:
    force = recording.force.copy()
    force[rng.integers(len(force), size=int(rng.integers(1, 3)))] = np.nan
    return replace(recording, force=force)


def _lost_character(recording: Recording, rng: np.random.Generator) -> Recording:
    """A number whose first character is lost: 1.0296 becomes .0296, -0.0131 becomes 0.0131."""
    force = recording.force.copy()
    at = int(np.argmax(force)) if force.max() >= 1.0 else int(rng.integers(len(force)))
    force[at] = force[at] - np.floor(force[at]) if force[at] >= 1.0 else abs(force[at])
    return replace(recording, force=force)


def _extra_samples(recording: Recording, rng: np.random.Generator) -> Recording:
    """A record that went on for up to a second: the last values with fresh time stamps."""
    count = int(rng.integers(500, 12_800))
    step = np.median(np.diff(recording.time))
    return replace(
        recording,
        time=np.concatenate([recording.time, recording.time[-1] + step * np.arange(1, count + 1)]),
        force=np.concatenate([recording.force, rng.choice(recording.force[-400:], count)]),
        flag=np.concatenate([recording.flag, np.zeros(count)]),
        voltage=np.concatenate([recording.voltage, rng.choice(recording.voltage[-400:], count)]),
    )


_ACTIONS = {
    "force_shift": _force_shift, "voltage_shift": _voltage_shift, "time_tail": _time_tail,
    "not_a_number": _not_a_number, "lost_character": _lost_character, "extra_samples": _extra_samples,
}  # fmt: skip
