"""The last step: all weighed hypotheses to diagnosis.json."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from eaclutch.diagnosis.causes import causes
from eaclutch.diagnosis.closure import absorbed, by_observable, gap_numbers, surely_left, total_gap, widened
from eaclutch.diagnosis.contact_law import other_contact_law
from eaclutch.diagnosis.free_swing import OSCILLATOR
from eaclutch.diagnosis.gate import simulate_null
from eaclutch.diagnosis.gaussian import Linearised, leave_out, log_normal
from eaclutch.diagnosis.localise import Explained, localise
from eaclutch.diagnosis.next_experiment import next_experiments
from eaclutch.diagnosis.placing import Entries
from eaclutch.diagnosis.repeatability import FEW, across_sessions
from eaclutch.diagnosis.result import CandidateResult, condition_groups, with_readings
from eaclutch.diagnosis.session_moves import sessions_apart
from eaclutch.diagnosis.study import SESSION_SPREADS, Study
from eaclutch.diagnosis.verdict import Verdict, built_on, decide, in_words, leading
from eaclutch.diagnosis.weigh import NONE, UNKNOWN, probabilities
from eaclutch.diagnosis.withheld import withheld

SESSION_DRIFT = "session_drift"
CAMPAIGNS = 400  # simulated, for every p-value and the noise floor, unless the config says otherwise
TOLD = 3  # values left out that the caveats name


def conclude(study: Study, results: Sequence[CandidateResult], campaigns: int = CAMPAIGNS) -> dict[str, Any]:
    """diagnosis.json (contract) from the base model's result and all others; ``campaigns``: how many are simulated for
    p-values and noise floor."""
    base = next(r for r in results if r.effects == NONE)
    linearised = with_readings(study.base, study.readings)
    _, groups = condition_groups(study.data)
    left = leave_out(linearised, groups)
    weights = probabilities(results, study.thresholds, surely_left(study, results))
    best, _ = leading(weights)
    largest = max([best, *built_on(best, weights)], key=lambda effects: weights[effects])
    notes = [*caveats(study), *far_apart(study, results, best), *stopped(results, largest)]
    notes += [*widened(study, results, best), *withheld(study, results, largest)]
    # the result whose predictions count as "after": the verdict's, the base model's where none is named
    after = next((r for r in results if r.effects == best), base)
    if best != UNKNOWN:  # the base model would bend with whatever that is
        notes += other_contact_law(study.constants(after), study.thresholds)
    verdict = decide(weights, results, study.thresholds, notes)
    strict = study.kernels.total(tolerance=0.0, session=session_spread(study, after), scatter=False)
    strict += np.diag(study.repeat_variance - study.kernels.noise_variance)
    null = simulate_null(linearised, strict, study.generator(11), campaigns)
    simulated = null.strict @ left.prediction_error.T
    squares = study.cells.mean_square(simulated[:, : study.data.run_entries])
    sound = with_readings(replace(study.base, linearised=study.sound), study.readings)
    # a place is looked for in the bench's capacitance, too, a width left out at a time
    elsewhere = leave_out(sound, [*groups, *Entries.of(study.data).of_widths()]).prediction_error
    # of the fit whose errors they are compared with: parameters that a gap has bent would pass for noise
    quiet = simulate_null(sound, strict, study.generator(11), campaigns).strict @ elsewhere.T
    where = localise(
        study.data,
        study.cells,
        elsewhere @ sound.w,
        quiet,
        study.generator(13),
        study.thresholds["place"],
        explained=_explained(study, verdict, after, results, sound),
    )
    units = {channel.name: channel.unit for channel in study.data.channels}
    closure = gap_numbers(study.cells, base, after, squares, study.generator(12))
    return {
        "schema": 1,
        "campaign": study.inputs.bench.name,
        "model": {"effects": list(study.inputs.effects)},
        "gap": {
            "total": total_gap(study.cells, base, after, squares, study.generator(14)),
            "by_observable": by_observable(
                study.cells, base, after, simulated, where.observable_p, units, study.generator(15)
            ),
        },
        "where": where.rows,
        "hypotheses": [
            {"effects": list(effects), "probability": weights[effects]}
            for effects in sorted(weights, key=lambda e: -weights[e])
        ],
        "causes": causes(study, results, weights, squares),
        "verdict": {
            "effects": list(verdict.effects), "probability": verdict.probability,
            "alternatives": [list(a) for a in verdict.alternatives], "why": verdict.why,
        },
        "closure": closure,
        "absorbed": absorbed(study.constants(base), study.constants(after)),
        "next_experiment": next_experiments(study, results, weights),
    }  # fmt: skip


def gap_summary(study: Study, base: CandidateResult) -> dict[str, Any]:
    """What the base model's fit says by itself: adequacy, by block, and how well repeats are known."""
    return {
        "adequate_p": base.adequate_p, "block_p": dict(base.block_p), "entries": len(study.data),
        "cells": len(study.cells.variance), "repeat_dof": study.dof, "notes": caveats(study),
    }  # fmt: skip


def _explained(
    study: Study,
    verdict: Verdict,
    after: CandidateResult,
    results: Sequence[CandidateResult],
    sound: Linearised,
) -> Explained | None:
    """What of the base model's errors the verdict accounts for, calibrated parameters following as in the ``sound`` fit
    that has these errors; None where there is no gap."""
    if verdict.effects == UNKNOWN:
        said = [np.array(r.shift) for r in results if r.effects == (verdict.like,)]
        shift = said[0] if said else study.remainder.discrepancy
    elif after.effects:
        shift = np.array(after.shift)
    else:
        return None
    # by the repeats alone: what laws may be off by would take up any effect
    noise = study.kernels.total(tolerance=0.0, session=0.0, scatter=False)
    return Explained.of(shift, sound.jacobian, noise)


def session_spread(study: Study, after: CandidateResult) -> float:
    """Spread between sessions, as a multiple of the assumed one, that is no effect: the base model's, or what the named
    effects leave of it, for what differs between sessions and has a name is no noise."""
    if not after.effects:
        return study.session_spread
    residual, tolerance = np.array(after.errors), after.multipliers[0]
    scores = [
        log_normal(residual, study.kernels.total(tolerance=tolerance, session=s)) for s in SESSION_SPREADS
    ]
    return min(study.session_spread, SESSION_SPREADS[int(np.argmax(scores))])


def stopped(results: Sequence[CandidateResult], best: tuple[str, ...]) -> list[str]:
    """A caveat where the base model's fit, or that of the most probable set, stopped before it had converged."""
    return [
        f"the fit with {in_words(r.effects)} stopped before it had converged"
        for r in results
        if r.effects in (NONE, best) and not r.converged
    ]


def far_apart(study: Study, results: Sequence[CandidateResult], best: tuple[str, ...]) -> list[str]:
    """A caveat where the most probable set (the base model for ``unknown``) needs the widest spread between sessions,
    unless it says itself that they drift."""
    widest = max(study.thresholds["multipliers"]["session"]["values"])
    needed = next(r.multipliers[1] for r in results if r.effects == (NONE if best == UNKNOWN else best))
    shares = sessions_apart(study.data, study.base.mode.predicted)
    # where the capacities do not differ, what lies apart is something else than the force
    least = study.thresholds["caveats"]["sessions_apart"]
    if SESSION_DRIFT in best or needed < widest or np.ptp(list(shares.values()) or [0.0]) < least:
        return []
    apart = ", ".join(f"{name} {share:+.0%}" for name, share in shares.items())
    return [
        f"sessions lie {widest:g} times as far apart as usual (shear capacity against the model's: {apart}), "
        "and that spread may hold a drift from session to session"
    ]


def caveats(study: Study) -> list[str]:
    """What this campaign cannot say, by name."""
    notes = [*study.data.bench.notes, *study.condensed]
    conditions, sessions = set(study.conditions.condition), set(study.conditions.session)
    if len(conditions) < 2:
        notes.append("one condition only: no condition can be left out, and nothing is known of any setting")
    if len(sessions) < 2:
        notes.append("one session only: session drift cannot be told")
    if odd := study.data.odd:
        more = f" and {len(odd) - TOLD} more" if len(odd) > TOLD else ""
        notes.append(f"left out, far from all repeats: {', '.join(odd[:TOLD])}{more}")
    most = max(study.dof.values(), default=0)
    if most < FEW:
        across = any(across_sessions(values, study.conditions).dof for values in study.data.run_values)
        seen = "what runs scatter by across sessions" if across else "what runs usually scatter by"
        notes.append(
            f"hardly any repeats ({most} degrees of freedom at most): the noise floor is drawn to {seen}"
            if most > 0
            else f"no repeats within a session: no noise floor, {seen} stands in"
        )
    if study.drift is not None:
        drift = study.drift
        notes.append(
            f"repeats of {drift.channel} follow the run order within a session ({drift.share:.0%} of their scatter, "
            f"p = {drift.p_value:.1g}), and the noise floor holds that drift"
        )
    if study.swings and OSCILLATOR not in study.inputs.effects:
        notes.append(f"{study.swings} runs swing freely after switch-off, which the model cannot")
    return notes
