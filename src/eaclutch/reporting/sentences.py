"""What the diagnosis says, in sentences with this run's numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from eaclutch.reporting.results import Results
from eaclutch.reporting.words import FACTORS, effect_words, number, observable_words, percent

MOST_OF_IT = 0.8  # of the closable gap; what closes less explains a part
LEAST_SHIFT = 0.5  # posterior standard deviations; smaller moves say nothing


def verdict_sentence(diagnosis: Mapping[str, Any]) -> str:
    """One sentence: what is missing from the model, how probable that is, how much of the gap it closes."""
    verdict = diagnosis["verdict"]
    effects, probability = verdict["effects"], percent(verdict.get("probability"))
    others = verdict.get("alternatives") or []
    if not effects:
        return (
            "No gap beyond repeatability: the model predicts what it has not seen as well as repeats allow "
            f"(probability {probability})."
        )
    if effects == ["unknown"]:
        return (
            f"There is a gap, and nothing in the library of effects explains it (probability {probability})."
        )
    named = effect_words(effects)
    closed = closure_words(diagnosis.get("closure") or {})
    further = [sorted(set(names) - set(effects)) for names in others if set(names) > set(effects)]
    rivals = [names for names in others if not set(names) > set(effects)]
    if rivals:
        listed = ", or ".join(effect_words(names) for names in rivals)
        return f"The gap points to {named} (probability {probability}), but these data cannot tell it from {listed}."
    if further:
        listed = " or ".join(effect_words(names) for names in further)
        closed += f"; whether {listed} adds to it, these data cannot tell"
    partly = "partly " if _left(diagnosis) else ""
    return f"The gap is {partly}explained by {named} (probability {probability}){closed}."


def _left(diagnosis: Mapping[str, Any]) -> bool:
    """Whether the verdict's effects leave a gap: one of them alone fails the absolute check, or all close little."""
    causes = {cause["effect"]: cause for cause in diagnosis.get("causes", [])}
    effects = diagnosis["verdict"]["effects"]
    if len(effects) == 1 and causes.get(effects[0], {}).get("adequate_after") is False:
        return True
    share = (diagnosis.get("closure") or {}).get("shrinkage")
    return share is not None and share < MOST_OF_IT


def closure_words(closure: Mapping[str, Any]) -> str:
    """`` , which closes 89 % (80 to 96) of it on left-out conditions``; empty without numbers.

    Beyond the noise floor there is nothing left to close: shares above 1 count as all.
    """
    share, interval = closure.get("shrinkage"), closure.get("interval")
    if share is None:
        return ""
    text = ", which closes all" if share >= 1 else f", which closes {percent(max(share, 0.0))}"
    if interval and None not in interval:
        low, high = (percent(min(max(end, 0.0), 1.0)) for end in interval)
        text += f" ({low} to {high})"
    return text + " of what can be closed, on conditions that the fit did not see"


def caveats(results: Results) -> list[str]:
    """What limits the verdict: rivals, confounded factors, stages that rest on priors or did not converge."""
    diagnosis, found = results.diagnosis, []
    verdict = diagnosis["verdict"]
    causes = {cause["effect"]: cause for cause in diagnosis.get("causes", [])}
    for name in (effect for effect in verdict["effects"] if effect != "unknown"):
        cause = causes.get(name, {})
        if cause.get("adequate_after") is False:
            found.append(
                f"With {effect_words([name])} the model still fails the absolute check: "
                "part of the gap stays unexplained."
            )
        if cause.get("indistinguishable_from"):
            rivals = ", ".join(effect_words([other]) for other in cause["indistinguishable_from"])
            found.append(f"In this campaign {effect_words([name])} looks like {rivals}.")
    confounded = {
        (entry["factor"], other)
        for entry in diagnosis.get("where", [])
        for other in entry.get("confounded_with") or ()
    }
    for factor, other in sorted(confounded):
        first, second = (_factor(name).partition(" (")[0] for name in (factor, other))
        found.append(
            f"{first.capitalize()} varies together with {second} here: the gap cannot be pinned on one of the two."
        )
    for stage, entry in results.summary.items():
        if entry.get("converged") is False:
            found.append(f"The {stage.replace('_', ' ')} posterior has not converged.")
        elif entry.get("source") == "prior":
            found.append(f"No usable data for the {stage.replace('_', ' ')}: it rests on its prior.")
    left_out = len(results.runs) - int((results.runs["usable"].astype(str).str.lower() == "true").sum())
    if left_out:
        found.append(
            f"{left_out} of {len(results.runs)} runs are not used; each is listed below with its reason."
        )
    return found


def where_sentences(diagnosis: Mapping[str, Any]) -> list[str]:
    """A sentence for each entry of ``where``, largest share first."""
    entries = sorted(diagnosis.get("where", []), key=lambda entry: -(entry.get("share") or 0))
    return [where_sentence(entry) for entry in entries]


def where_sentence(entry: Mapping[str, Any]) -> str:
    """What is off, at which level of which factor, by which share of the closable gap."""
    level = "" if entry["factor"] == "all" else f" at {level_words(entry['factor'], str(entry['level']))}"
    sign = {"+": "above", "-": "below"}.get(entry.get("direction", ""), "off")
    interval = entry.get("interval") or [None, None]
    share = percent(entry.get("share"))
    if None not in interval:
        share += f" ({percent(interval[0])} to {percent(interval[1])})"
    return (
        f"{observable_words(entry['observable']).capitalize()}{level} lies {sign} the prediction: "
        f"{share} of the closable gap, p = {number(entry.get('p_value'), 2)}."
    )


def level_words(factor: str, level: str) -> str:
    """``drive frequency ≤ 10 Hz`` from a factor's name and a level such as ``<=10``."""
    name, _, unit = _factor(factor).partition(" (")
    if factor == "frequency_hz" and level in ("0.1", "<=0.1"):
        return "DC"
    shown = level.replace("<=", "≤ ").replace(">=", "≥ ")
    return f"{name} {shown} {unit.rstrip(')')}".strip()


def absorption_sentences(diagnosis: Mapping[str, Any]) -> list[str]:
    """How far each calibrated parameter moves back once the named effect is in the model."""
    sentences = []
    moved = (diagnosis.get("absorbed") or {}).items()
    for name, entry in sorted(moved, key=lambda item: -abs(item[1].get("shift_posterior_sd") or 0)):
        if abs(entry.get("shift_posterior_sd") or 0) < LEAST_SHIFT:
            continue
        unit = "" if entry.get("unit") in (None, "1") else f" {entry['unit']}"
        sentences.append(
            f"{name.replace('_', ' ')}: {number(entry.get('before'))} → {number(entry.get('after'))}{unit}"
            f" ({number(entry.get('shift_posterior_sd'), 2)} posterior sd)"
        )
    return sentences


def _factor(name: str) -> str:
    return FACTORS.get(name, name.replace("_", " "))
