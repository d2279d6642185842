"""What a reader wants at first: where the gap sits, how far it closes, what was left out, what to do next."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.reporting.results import Results
from eaclutch.reporting.sentences import closes, gap_words, place_words
from eaclutch.reporting.words import effect_words, number, observable_words, percent, plain

LEADING = ("shear_capacity_n", "release_time_90_s")  # whose missing values the first screen counts
MOST_PLACES = 3
TELLING = load_thresholds()["sentences"]["telling_nats"]
REASONS = {
    "no_voltage": "the voltage never came on",
    "no_zero": "no stretch without contact: absolute forces hold the session's zero",
    "force_not_in_step": "lines of the force column are lost at places that cannot be told",
    "force_lines_lost": "lines of the force column are lost",
    "voltage_lines_lost": "lines of the voltage column are lost; events are read from the flag",
    "force_realigned": "the force column was moved back into step",
    "force_realigned_from_release": "the force column was moved back into step from the release on",
    "force_in_step_until_release": "the force column is in step up to the release",
    "force_glitch": "single force values were damaged and replaced by their neighbours' mean",
    "time_realigned": "parts of the time column were moved back into place",
    "time_repaired": "single time stamps were repaired",
    "level_in_noise": "the level to be crossed drowns in the noise",
    "off_unsure": "when the voltage fell cannot be told to some milliseconds",
    "no_release": "the force does not fall after the voltage",
    "no_swing": "no free swing stands out after the release",
    "no_slip": "no slip stands out while driven",
    "slips_at_rest": "a slip while the stage rests: the creep is its slope, and does not count",
    "slips_crowded": "slips follow one another too fast to be told apart",
    "stage_moves_until_off": "the stage never rests under voltage",
    "cut_short": "the log ends early",
}


def glance(results: Results) -> list[tuple[str, str]]:
    """(head, sentence) of the lines beneath the verdict; heads without anything to say are left out."""
    lines = {
        "Where" if results.diagnosis["verdict"]["effects"] else "Largest misfit": where_line(
            results.diagnosis
        ),
        "How far": how_far_line(results.diagnosis),
        "Runs": runs_line(results),
        "Next": next_line(results.diagnosis),
    }
    return [(head, text) for head, text in lines.items() if text]


def where_line(diagnosis: Mapping[str, Any]) -> str:
    """The leading places of the gap with their shares."""
    entries = sorted(diagnosis.get("where", []), key=lambda entry: -(entry.get("share") or 0))[:MOST_PLACES]
    if not entries:
        return ""
    first, *others = [(place_words(entry), percent(entry.get("share"))) for entry in entries]
    told = [f"{first[0]} ({first[1]} of the {gap_words(diagnosis)})"]
    told += [f"{place[:1].lower()}{place[1:]} ({share})" for place, share in others]
    return "; ".join(told) + "."


def how_far_line(diagnosis: Mapping[str, Any]) -> str:
    """The squared error before and after the verdict's effects, and what a right model would have."""
    closure, total = diagnosis.get("closure") or {}, (diagnosis.get("gap") or {}).get("total") or {}
    before, after = closure.get("before", total.get("before")), closure.get("after")
    floor = closure.get("noise_floor", total.get("noise_floor"))
    if before is None or floor is None:
        return ""
    named = diagnosis["verdict"]["effects"]
    text = f"On conditions that the fit did not see, the squared error is {number(before)} times the repeats' variance"
    end = f"with a right model, noise and sessions alone would make it {number(floor)}."
    if after is None or not named or named == ["unknown"]:
        return f"{text}; {end}"
    share = closure.get("shrinkage")
    closed = "" if share is None or share < 0 else f"; that {closes(closure)}"
    return f"{text}, with {effect_words(named)} {number(after)}{closed}; {end}"


def runs_line(results: Results) -> str:
    """Runs that are not used, with their reasons, and how many lack a leading observable."""
    runs = results.runs
    used = runs["usable"].astype(str).str.lower() == "true"
    excluded = results.quality.get("excluded") or {}
    whys = Counter(
        f"by campaign.yaml: {excluded[row.run]}"
        if row.run in excluded
        else reasons_in_words(row.flags, row.reasons)
        for row in runs[~used].itertuples()
    )
    unused = int((~used).sum())
    text = (
        f"{unused} of {len(runs)} runs {'is' if unused == 1 else 'are'} not used"
        if unused
        else f"All {len(runs)} are used"
    )
    if len(whys) == 1:
        text += f" ({next(iter(whys))})"
    elif whys:
        text += f" ({'; '.join(f'{count}: {why}' for why, count in whys.most_common())})"
    for name in (name for name in LEADING if name in runs):
        missing = int(runs.loc[used, name].isna().sum())
        if missing:
            more, verb = " more" if unused else "", "gives" if missing == 1 else "give"
            text += f"; {missing}{more} {verb} no {observable_words(name)}"
    return text + "."


def missing_table(results: Results) -> list[tuple[str, int, str]]:
    """(observable, runs that yield it, reasons with counts), of the observables that some run does not yield."""
    rows = []
    for name, reasons in (results.quality.get("unusable") or {}).items():
        if reasons:
            told = ", ".join(
                f"{reason.replace('_', ' ')} {count}"
                for reason, count in sorted(reasons.items(), key=lambda item: -item[1])
            )
            rows.append((observable_words(name), len(results.runs) - sum(reasons.values()), told))
    return rows


def glossary(results: Results) -> list[tuple[str, str, int]]:
    """(name, meaning, runs) of the flags and reasons that this campaign has."""
    counts = Counter(results.quality.get("flags") or {})
    for reasons in (results.quality.get("unusable") or {}).values():
        for reason, count in reasons.items():
            counts[reason] = max(counts[reason], count)
    return [(name.replace("_", " "), REASONS.get(name, ""), count) for name, count in counts.most_common()]


def reasons_in_words(flags: str, reasons: str) -> str:
    """The flags of a run that is not used, else why its observables are missing, each once."""
    names: Iterable[str] = [flag for flag in str(flags).split(";") if flag and flag != "no_zero"]
    names = names or [item.partition(":")[2] for item in str(reasons).split(";") if item]
    return ", ".join(dict.fromkeys(REASONS.get(name, name.replace("_", " ")) for name in names))


def next_line(diagnosis: Mapping[str, Any]) -> str:
    """The most telling next runs, or nothing where nothing is left to separate."""
    entries = diagnosis.get("next_experiment") or []
    if not entries:
        return ""
    best = entries[0]
    doubt = _doubt(diagnosis)
    gain = f"expected to settle {number(min(best['information_nats'], doubt), 2)} of {number(doubt, 2)} nats of doubt"
    if best["information_nats"] < TELLING:
        where = (
            ": look for what is missing where the gap sits"
            if diagnosis["verdict"]["effects"] == ["unknown"]
            else ""
        )
        return f"No run within the rig's limits would tell apart what was weighed ({gain} at most){where}."
    frequency = "DC" if best["frequency_hz"] == 0.1 else f"{plain(best['frequency_hz'])} Hz"
    apart = " from ".join(set_words(name) for name in best["separates"])
    return (
        f"{best['runs']} runs at {plain(best['voltage_v'])} V, {frequency}, width {plain(best['width_mm'])} mm, "
        f"preload {plain(best['preload_n'])} N would best tell {apart} ({gain})."
    )


def _doubt(diagnosis: Mapping[str, Any]) -> float:
    """Entropy [nats] of the probabilities over what was weighed: what there is to settle."""
    weights = [entry["probability"] for entry in diagnosis.get("hypotheses", []) if entry["probability"] > 0]
    return -sum(weight * math.log(weight) for weight in weights)


def set_words(joined: str) -> str:
    """``a_b+c`` as ``a b with c``, ``none`` as ``no gap``."""
    return " with ".join(effect_words([] if name == "none" else [name]) for name in joined.split("+"))
