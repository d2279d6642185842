"""What the diagnosis says, in sentences with this run's numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.reporting.results import Results
from eaclutch.reporting.words import (
    FACTORS,
    effect_words,
    holds_the_pair,
    number,
    observable_words,
    percent,
    scale_for,
)

RULES = load_thresholds()["sentences"]
MOST_SHIFTS = 8  # of the ledger's entries on the page; the rest stands in the file
_SIGNS = {"<=": "≤", ">=": "≥", "<": "<", ">": ">"}


def verdict_sentence(diagnosis: Mapping[str, Any]) -> str:
    """One sentence: what is missing from the model, how probable that is, how much of the gap it closes."""
    verdict = diagnosis["verdict"]
    effects, probability = verdict["effects"], percent(verdict.get("probability"))
    others = [names for names in verdict.get("alternatives") or [] if not holds_the_pair(names, effects)]
    probability += _with_a_third(diagnosis)
    if not effects and others:
        listed = " or ".join(effect_words(names) for names in others)
        return (
            f"Most probably there is no gap beyond repeatability ({probability}), but {listed} cannot be ruled out"
            f"{_tolerated(diagnosis)}."
        )
    if not effects and _tolerated(diagnosis):
        return f"No gap that needs a missing effect (probability {probability}){_tolerated(diagnosis)}."
    if not effects:
        return (
            "No gap beyond repeatability: the model predicts what it has not seen as well as repeats allow "
            f"(probability {probability})."
        )
    if effects == ["unknown"]:
        weighed = sum(cause["effect"] not in ("none", "unknown") for cause in diagnosis.get("causes", []))
        which = (
            f"none of the {weighed} effects weighed" if weighed > 1 else "nothing in the library of effects"
        )
        return f"There is a gap, and {which} explains it (probability {probability}{_not_ruled_out(others)})."
    named = effect_words(effects)
    closed = closure_words(diagnosis.get("closure") or {})
    larger = [names for names in others if set(names) > set(effects)]
    smaller = [names for names in others if names and set(names) < set(effects)]
    rivals = [names for names in others if names not in larger and names not in smaller]
    if rivals:
        alone = [effect_words(names) + " alone" for names in smaller]
        listed = " or ".join([*(effect_words(names) for names in (*rivals, *larger)), *alone])
        start = f"The gap points to {named} (probability {probability}), but"
        if (verdict.get("probability") or 0.0) >= RULES["probable"]:
            return f"{start} {listed} cannot be ruled out."
        return f"{start} these data cannot tell it from {listed}."
    if larger:
        listed = " or ".join(effect_words(sorted(set(names) - set(effects))) for names in larger)
        closed += f"; whether {listed} adds to it, these data cannot tell"
    if smaller:
        listed = " or ".join(effect_words(sorted(set(effects) - set(names))) for names in smaller)
        closed += f"; whether {listed} is needed for that, these data cannot tell"
    partly = "partly " if _left(diagnosis) else ""
    return f"The gap is {partly}explained by {named} (probability {probability}){closed}."


def _with_a_third(diagnosis: Mapping[str, Any]) -> str:
    """``; 70 % with air gap besides`` for each alternative of three that holds the pair named; else empty."""
    verdict = diagnosis["verdict"]
    weights = {tuple(e["effects"]): e["probability"] for e in diagnosis.get("hypotheses", [])}
    return "".join(
        f"; {percent(weights.get(tuple(names)))} with "
        f"{effect_words(name for name in names if name not in verdict['effects'])} besides"
        for names in verdict.get("alternatives") or []
        if holds_the_pair(names, verdict["effects"])
    )


def _tolerated(diagnosis: Mapping[str, Any]) -> str:
    """``; the model misses by more than noise does (9.6 against 3.1), ...`` where the gap stands well above its floor
    though no effect is named; else empty."""
    total = (diagnosis.get("gap") or {}).get("total") or {}
    before, floor = total.get("before"), total.get("noise_floor")
    if before is None or floor is None or before <= RULES["above_floor"] * floor:
        return ""
    return (
        f"; the model misses by more than noise does ({number(before, 2)} against {number(floor, 2)}), "
        "no further than its base laws may be off"
    )


def _not_ruled_out(others: Sequence[Sequence[str]]) -> str:
    """``; that there is no gap cannot be ruled out``, or nothing where there is no alternative."""
    listed = " or ".join(effect_words(names) if names else "that there is no gap" for names in others)
    return f"; {listed} cannot be ruled out" if listed else ""


def _left(diagnosis: Mapping[str, Any]) -> bool:
    """Whether the verdict's effects leave a gap: one of them alone fails the absolute check, or more is left than
    noise leaves (less than most of it is closed and the closure's interval ends below 1)."""
    causes = {cause["effect"]: cause for cause in diagnosis.get("causes", [])}
    effects = diagnosis["verdict"]["effects"]
    if len(effects) == 1 and causes.get(effects[0], {}).get("adequate_after") is False:
        return True
    closure = diagnosis.get("closure") or {}
    share, (_, most) = closure.get("shrinkage"), closure.get("interval") or (None, None)
    return share is not None and share < RULES["most_of_it"] and (most is None or most < 1.0)


def closure_words(closure: Mapping[str, Any]) -> str:
    """`` , which closes 89 % (80 to 96) of it on left-out conditions``; empty without numbers."""
    if closure.get("shrinkage") is None:
        return ""
    return f", which {closes(closure)}, on conditions that the fit did not see"


def closes(closure: Mapping[str, Any]) -> str:
    """``closes 89 % (80 % to 96 %) of what can be closed``, of a share that is known.

    Beyond the noise floor there is nothing left to close: shares above 1 count as all.
    """
    share, interval = closure["shrinkage"], closure.get("interval")
    text = "closes all" if share >= 1 else f"closes {percent(max(share, 0.0))}"
    if interval and None not in interval:
        low, high = (percent(min(max(end, 0.0), 1.0)) for end in interval)
        text += f" ({low} to {high})"
    return text + " of what can be closed"


def caveats(results: Results) -> list[str]:
    """What limits the verdict: rivals, confounded factors, stages that rest on priors or did not converge."""
    diagnosis, found = results.diagnosis, []
    verdict = diagnosis["verdict"]
    causes = {cause["effect"]: cause for cause in diagnosis.get("causes", [])}
    named = [effect for effect in verdict["effects"] if effect != "unknown"]
    if named and _left(diagnosis):
        found.append(
            f"With {effect_words(named)} in the model, part of the gap still stays unexplained: something else is "
            "missing, too. The probability only compares what was weighed: effects alone and in pairs."
        )
    for name in named:
        others = [
            other for other in causes.get(name, {}).get("indistinguishable_from") or () if other not in named
        ]
        if others:
            rivals = " or ".join(effect_words([other]) for other in others)
            found.append(
                f"In this campaign {rivals} could stand for {effect_words([name])}: about as probable alone."
            )
    confounded = {
        (entry["factor"], other)
        for entry in diagnosis.get("where", [])
        for other in entry.get("confounded_with") or ()
    }
    for factor, other in sorted(confounded):
        first, second = (factor_words(name) for name in (factor, other))
        found.append(
            f"{first.capitalize()} varies together with {second} here: the gap cannot be pinned on one of the two."
        )
    for stage, entry in results.summary.items():
        if entry.get("converged") is False:
            found.append(f"The {stage.replace('_', ' ')} posterior has not converged.")
        elif entry.get("source") == "prior":
            found.append(f"No usable data for the {stage.replace('_', ' ')}: it rests on its prior.")
    return found


def where_sentences(diagnosis: Mapping[str, Any]) -> list[str]:
    """A sentence for each entry of ``where``, largest share first."""
    entries = sorted(diagnosis.get("where", []), key=lambda entry: -(entry.get("share") or 0))
    return [where_sentence(entry, gap_words(diagnosis)) for entry in entries]


def gap_words(diagnosis: Mapping[str, Any]) -> str:
    """What shares are shares of: without a gap, what lies beyond the floor is a misfit that chance may make."""
    return "closable gap" if diagnosis["verdict"]["effects"] else "misfit"


def where_sentence(entry: Mapping[str, Any], whole: str = "closable gap") -> str:
    """What is off, at which level of which factor, by which share of the whole."""
    interval = entry.get("interval") or [None, None]
    share = percent(entry.get("share"))
    if None not in interval:
        share += f" ({percent(interval[0])} to {percent(interval[1])})"
    chance = f"p = {number(entry.get('p_value'), 2)}"
    if (entry.get("p_value") or 0.0) >= 0.05:
        chance = f"which alone, without the rest, noise could have made ({chance})"
    return f"{place_words(entry)}: {share} of the {whole}, {chance}."


def place_words(entry: Mapping[str, Any]) -> str:
    """``Shear capacity at substrate width > 3 mm lies below the prediction``."""
    level = "" if entry["factor"] == "all" else f" {level_words(entry['factor'], str(entry['level']))}"
    sign = {"+": "above", "-": "below"}.get(entry.get("direction", ""), "off")
    name = observable_words(entry["observable"])
    return f"{name[:1].upper()}{name[1:]}{level} lies {sign} the prediction"


def level_words(factor: str, level: str) -> str:
    """``at drive frequency ≤ 10 Hz`` from a factor's name and a level such as ``<=10``; ``in session a``."""
    if factor == "session":
        return f"in session {level}"
    name, _, unit = FACTORS.get(factor, factor_words(factor)).partition(" (")
    if factor == "frequency_hz" and level in ("0.1", "<=0.1"):
        return "at DC"
    shown = re.sub(r"^(<=|>=|<|>)\s*", lambda sign: _SIGNS[sign[1]] + "\u00a0", level)
    return f"at {name} {shown}\u00a0{unit.rstrip(')')}".strip()


def absorption_sentences(diagnosis: Mapping[str, Any]) -> list[str]:
    """How far the calibrated parameters move back once the named effect is in the model, farthest first."""
    moved = (diagnosis.get("absorbed") or {}).items()
    order = sorted(moved, key=lambda item: -abs(item[1].get("shift_posterior_sd") or 0))
    told = [
        (name, entry)
        for name, entry in order
        if abs(entry.get("shift_posterior_sd") or 0) >= RULES["least_shift_sd"]
    ]
    sentences = []
    for name, entry in told[:MOST_SHIFTS]:
        ends = [entry.get("before"), entry.get("after")]
        scale = scale_for([value for value in ends if value is not None], entry.get("unit") or "1")
        before, after = (number(None if value is None else float(scale(value))) for value in ends)
        shift = entry["shift_posterior_sd"]
        sentences.append(
            f"{name.replace('_', ' ')}: {before} → {after} {scale.unit}".rstrip()
            + f" ({number(abs(shift), 2)} posterior sd {'down' if shift > 0 else 'up'})"
        )
    if len(told) > MOST_SHIFTS:
        sentences.append(f"{len(told) - MOST_SHIFTS} more by less; all are in diagnosis/diagnosis.json")
    return sentences


def factor_words(name: str) -> str:
    """``voltage`` for ``voltage_v``."""
    return FACTORS.get(name, name.replace("_", " ")).partition(" (")[0]
