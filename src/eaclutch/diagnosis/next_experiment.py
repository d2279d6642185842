"""The few runs within what the rig has shown that it can do that would best separate what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from eaclutch.diagnosis.readings import Readings
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.weigh import UNKNOWN, unknown_as
from eaclutch.records import FloatArray, RunConditions

# below the campaign's largest, which stands beside them: no supply is asked for more than it has given
VOLTAGES = (100.0, 200.0, 300.0)
FREQUENCIES = (0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0)
PRELOADS = (0.1, 0.5, 1.0)
RUNS = 5
SHOWN = 3
CONTENDERS = 4
SMALLEST_WEIGHT = 0.01
APART = 0.1  # squared sds, nearer than which runs cannot bring two hypotheses apart


def next_experiments(
    study: Study,
    results: Sequence[CandidateResult],
    weights: Mapping[tuple[str, ...], float],
) -> list[dict[str, Any]]:
    """Contract's ``next_experiment``: the conditions of largest expected information, the best first.

    The information is that of which hypothesis is true, by the Bhattacharyya bound on a mixture of Gaussians
    (Kolchinsky & Tracey 2017, doi:10.3390/e19070361), from the predictions at each hypothesis' own fit, the observables
    taken as independent. ``unknown`` predicts what its best lookalike does, and nothing where that is a nameless term.
    """
    grid, variance = _grid(study), _variance(study)
    contenders, predictions = _contenders(study, results, weights, grid, variance)
    if len(contenders) < 2:
        return []
    p = np.array([max(weights[e], 1e-3) for e in contenders])
    p = p / p.sum()
    distance = (predictions[:, None] - predictions[None]) ** 2 / variance[:, None]
    distance = np.nansum(distance, axis=2)  # (i, j, settings)
    information = -np.einsum("i,ig->g", p, np.log(np.einsum("j,ijg->ig", p, np.exp(-distance / 8.0))))
    if UNKNOWN not in contenders:
        # as far as one of them is true at all: what the library lacks predicts nothing that could be separated
        information *= 1.0 - weights.get(UNKNOWN, 0.0)
    found: list[dict[str, Any]] = []
    for i in np.argsort(-information):
        pair = _separated(distance[:, :, i], p)
        entry = {
            "voltage_v": float(grid.voltage[i]), "frequency_hz": float(grid.frequency[i]),
            "width_mm": float(grid.width[i] * 1e3), "preload_n": float(_preload(study, grid)[i]), "runs": RUNS,
            "information_nats": max(0.0, float(information[i])),
            "separates": ["+".join(contenders[k]) or "none" for k in pair],
        }  # fmt: skip
        if all(
            entry["frequency_hz"] != f["frequency_hz"] or entry["width_mm"] != f["width_mm"] for f in found
        ):
            found.append(entry)
        if len(found) == SHOWN:
            break
    return found


def _contenders(
    study: Study,
    results: Sequence[CandidateResult],
    weights: Mapping[tuple[str, ...], float],
    grid: RunConditions,
    variance: FloatArray,
) -> tuple[list[tuple[str, ...]], FloatArray]:
    """The most probable hypotheses and what each predicts (contenders, channels, settings): two at least, as far as
    there are any that differ somewhere on the grid from those before them (a pair whose second effect does nothing is
    no rival of the first)."""
    fitted = {r.effects: r for r in results}
    like = unknown_as(results, study.thresholds)
    if like:
        fitted[UNKNOWN] = fitted[like,]
    kept: list[tuple[str, ...]] = []
    said: list[FloatArray] = []
    for effects in sorted((e for e in weights if e in fitted), key=lambda e: -weights[e]):
        if len(kept) == CONTENDERS or (len(kept) > 1 and weights[effects] < SMALLEST_WEIGHT):
            break
        predicted = _predict(study, fitted[effects], grid)
        apart = [np.max(np.nansum((predicted - other) ** 2 / variance[:, None], axis=0)) for other in said]
        if min(apart, default=np.inf) > APART:
            kept.append(effects)
            said.append(predicted)
    return kept, np.array(said)


def _separated(distance: FloatArray, p: FloatArray) -> tuple[int, int]:
    """The two contenders whose separation counts most there."""
    gain = np.outer(p, p) * -np.expm1(-distance / 8.0)
    i, j = np.triu_indices(len(p), 1)
    most = int(np.argmax(gain[i, j]))
    return int(i[most]), int(j[most])


def _grid(study: Study) -> RunConditions:
    """All settings worth asking for, as runs of the campaign's last session: widths that its substrates have."""
    runs = study.conditions
    name = runs.substrate[0]
    strips = zip(runs.substrate, runs.width, runs.thickness, strict=True)
    thickness = {round(w * 1e3, 6): t for of, w, t in strips if of == name}
    substrate = study.inputs.bench.substrates.get(name)
    if substrate is not None:
        thickness = {round(w * 1e3, 6): t for w, t in substrate.thickness.items()} | thickness
    sums = study.inputs.bench.friction.sliding
    voltages, frequencies = _up_to(VOLTAGES, runs.voltage), _up_to(FREQUENCIES, runs.frequency)
    rows = [(v, f, w * 1e-3, thickness[w], sums * p, p) for v in voltages for f in frequencies
            for w in sorted(thickness) for p in PRELOADS]  # fmt: skip
    table = np.array(rows)
    nearest = np.array([int(np.argmin(np.abs(np.log(runs.frequency / f)))) for f in table[:, 1]])
    n = len(rows)
    label = tuple(f"setting {i}" for i in range(n))
    last = int(np.argmax(np.asarray(runs.session_number)))
    return RunConditions(
        label, (runs.session[last],) * n, label, (name,) * n, table[:, 0], table[:, 1], table[:, 2],
        table[:, 3], table[:, 4], np.full(n, np.nan), runs.drive_duration[nearest], runs.dwell[nearest],
        np.zeros(n), np.full(n, np.asarray(runs.session_number)[last]),
    )  # fmt: skip


def _up_to(levels: Sequence[float], used: FloatArray) -> list[float]:
    """The levels below the largest that the campaign ``used`` (runs,), and that one."""
    largest = float(np.max(used))
    return [*(level for level in levels if level < largest), largest]


def _preload(study: Study, grid: RunConditions) -> FloatArray:
    return grid.friction_before / study.inputs.bench.friction.sliding


def _predict(study: Study, result: CandidateResult, grid: RunConditions) -> FloatArray:
    """(channels, settings) on the comparison scale, not-a-number where the model gives none."""
    named = {name: np.array([value]) for name, value in result.named.items()}
    plain = Readings((), np.full(len(grid), -1), False)
    return plain.predict(study.model(result.effects), grid, plain.without(named), study.data.channels)[0]


def _variance(study: Study) -> FloatArray:
    """(channels,): of a mean over RUNS repeats in one session, with the tolerance and what the model misses of one
    condition (where a tip comes to rest is nearly chance, however often it is repeated)."""
    t = study.thresholds
    typical = {}
    for channel in study.data.channels:
        rows = study.data.channel == channel.name
        single = float(np.median(study.data.noise_sd[rows] ** 2 * study.data.count[rows]))
        typical[channel.name] = (
            single / RUNS
            + t["session_sd"][channel.block] ** 2
            + t["tolerance"][channel.block] ** 2
            + t["scatter"].get(channel.block, 0.0) ** 2
        )
    return np.array([typical[c.name] for c in study.data.channels])
