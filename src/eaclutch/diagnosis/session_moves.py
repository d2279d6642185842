"""What sessions differ by in one piece: a stiffer contact moves capacity, slips and releases of its session together.

The session spread by block (covariance) knows nothing of that, and takes such a session for a cause.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from eaclutch.diagnosis.covariance import Kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.mode import gentler
from eaclutch.records import FloatArray

STEP = 0.02  # of a parameter's logarithm
CAPACITY = "shear_capacity_n"
STEEPEST = 10.0  # change of an entry per unit of that; a run on the verge of sticking jumps


def session_moves(
    forward: Forward, at: Mapping[str, float], terms: Sequence[Mapping[str, Any]]
) -> FloatArray:
    """How far one sd of each term moves the entries, (terms, entries).

    forward: the campaign's own model; at: its parameters {name: value}; terms: [{sd, parameters}], the sd between
    sessions of the logarithm of ``parameters``, which change together (thresholds). Bench entries do not move: another
    mounting, with offsets of its own.
    """
    moves = np.zeros((len(terms), len(forward.data)))
    n = forward.data.run_entries
    for i, term in enumerate(terms):
        names = [name for name in term["parameters"] if name in at]
        if not names:
            continue
        points = {name: np.full(3, value) for name, value in at.items()}
        for name in names:
            points[name] = at[name] * np.exp([-STEP, 0.0, STEP])
        found = forward.representative.predict_named(points, 3)[:, :n]
        slope = gentler(*np.diff(found, axis=0) / STEP)
        moves[i, :n] = term["sd"] * np.where(np.abs(slope) < STEEPEST, slope, 0.0)
    return moves


def with_sessions(kernels: Kernels, sessions: np.ndarray, moves: FloatArray) -> Kernels:
    """``kernels`` whose sessions also differ by ``moves`` (terms, entries), each session in its own way; sessions
    (entries,): their names."""
    same = sessions[:, None] == sessions[None, :]
    return replace(kernels, session=kernels.session + (moves.T @ moves) * same)


def sessions_apart(data: DataVector, predicted: FloatArray) -> dict[str, float]:
    """By what share the shear capacity of each session stands above what the model says of all, {session: share};
    predicted: (entries,). Empty without capacities of two sessions."""
    n = data.run_entries
    used = np.flatnonzero(data.channel[:n] == CAPACITY)
    sessions = data.session[used]
    if len(set(sessions)) < 2:
        return {}
    left, weight = (data.values - predicted)[used], 1.0 / data.noise_sd[used] ** 2
    return {
        str(name): float(np.expm1(np.average(left[sessions == name], weights=weight[sessions == name])))
        for name in sorted(set(sessions))
    }
