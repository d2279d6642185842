"""The page of the sealed benchmark: every number of it comes from score.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from eaclutch.reporting.drawing import BLUE, GREY, VERMILION, Picture, canvas, picture
from eaclutch.reporting.study_page import Section, Table, render_study

KINDS = {
    "none": "no effect",
    "single": "one effect",
    "unknown": "an effect the library lacks",
    "pair": "two effects",
}
# (words, path in a method's scores, target in words)
GOALS = (
    ("one identifiable effect: its name first", ("identifiable", "first"), "0.90"),
    ("one identifiable effect: probability on it", ("identifiable", "probability_of_truth"), "0.75"),
    ("a name though there is no effect", ("false_alarms",), "0.02 at most"),
    ("`unknown` said of an effect the library lacks", ("unknown_recognised",), "0.80"),
    ("a wrong name for an effect the library lacks", ("wrong_name_on_unknown",), "0.05 at most"),
    ("verdict or alternatives hold the truth", ("set_holds_truth",), "0.95"),
    ("members of that set", ("set_size",), "1.5 on average"),
    ("90 % closure intervals that hold the true closure", ("closure", "covered"), "0.85-0.95"),
    ("90 % intervals of k, effect added", ("parameters", "contact_stiffness", "after", "covered"), "0.85-0.95"),
    ("90 % intervals of sigma, effect added", ("parameters", "roughness_sd", "after", "covered"), "0.85-0.95"),
)  # fmt: skip
FURTHER = (
    ("right verdict, all cases", ("right",)),
    ("right verdict, one effect of any size", ("right_by_kind", "single")),
    ("right verdict, two effects", ("right_by_kind", "pair")),
    ("probability on the truth, one effect", ("probability_of_truth_by_kind", "single")),
    ("truth ranked first", ("first",)),
    ("truth among the first two", ("first_two",)),
    ("mean probability on the truth", ("probability_of_truth",)),
    ("log score", ("log_score",)),
    ("Brier score", ("brier",)),
    ("calibration error", ("calibration",)),
    ("wrong name beside an effect", ("wrong_name_on_effect",)),
    ("`unknown` said though there is no effect", ("unknown_said_without_gap",)),
    ("effect taken out of the library: `unknown`", ("left_out", "unknown")),
    ("effect taken out of the library: a name", ("left_out", "named")),
    ("where: observable", ("where", "observable")),
    ("where: phase", ("where", "phase")),
    ("where: factor", ("where", "factor")),
    ("closure error, absolute", ("closure", "absolute_error")),
    ("contact stiffness: error in sd, before", ("parameters", "contact_stiffness", "before", "size")),
    ("contact stiffness: error in sd, after", ("parameters", "contact_stiffness", "after", "size")),
    ("roughness: error in sd, before", ("parameters", "roughness_sd", "before", "size")),
    ("roughness: error in sd, after", ("parameters", "roughness_sd", "after", "size")),
    ("right verdict, from tables", ("by_level", "tables")),
    ("right verdict, from raw logs", ("by_level", "logs")),
    ("seconds a case", ("seconds",)),
)


def blind_page(score: Mapping[str, Any], title: str = "The sealed benchmark") -> str:
    """One page from the score of one size; the first method is the library, the others stand beside it."""
    methods = dict(sorted(score["methods"].items(), key=lambda item: (item[0] != "library", item[0])))
    if not methods:
        return render_study(title, "Nothing was diagnosed.", [])
    main = "library" if "library" in methods else next(iter(methods))
    own = methods[main]
    counts = ", ".join(f"{score['kinds'][kind]} with {words}" for kind, words in KINDS.items())
    lead = (
        f"{score['cases']} campaigns whose cause was withheld: {counts}. The verdict was exactly right in "
        f"{_words(own['right'])} of them. Intervals hold 90 %."
    )
    sections = [
        Section("Against the goals", tables=[_goals(own)]),
        Section("All scores", _notes(methods), tables=[_comparison(methods)]),
        Section(
            "Which effects are found", pictures=[_effects(own), _distances(own)], tables=[_effect_table(own)]
        ),
        Section("Are the probabilities honest", pictures=[_calibration(own)]),
        Section("Truth and verdict", tables=[_confusion(own, score.get("forecast"))]),
        Section("What passes for what: effects that the library lacks", tables=[_strangers(own)]),
    ]
    return render_study(title, lead, [section for section in sections if section.tables or section.pictures])


def _get(scores: Mapping[str, Any], path: Sequence[str]) -> Mapping[str, Any]:
    for key in path:
        scores = scores[key]
    return scores


def _words(item: Mapping[str, Any]) -> str:
    value = item.get("value", item.get("error"))
    if value is None:
        return "no case"
    text = f"{value:.3g}"
    if item.get("interval"):
        text += f" ({item['interval'][0]:.3g} to {item['interval'][1]:.3g})"
    return text + (f", {item['count']} of {item['of']}" if "count" in item else "")


def _goals(own: Mapping[str, Any]) -> Table:
    return Table(
        ["what", "found", "goal"], [(what, _words(_get(own, path)), goal) for what, path, goal in GOALS]
    )


def _comparison(methods: Mapping[str, Any]) -> Table:
    rows = [(what, *(_words(_get(scores, path)) for scores in methods.values())) for what, path in FURTHER]
    return Table(["score", *methods], rows)


def _notes(methods: Mapping[str, Any]) -> list[str]:
    notes = []
    for name, scores in methods.items():
        when = "after the answers were opened" if scores["after_opening"] else "before any answer was opened"
        missing = f" {len(scores['missing'])} cases have no verdict." if scores["missing"] else ""
        notes.append(f"{name}: verdicts frozen {when}, {scores['frozen'][:16]}.{missing}")
    return notes


def _effect_table(own: Mapping[str, Any]) -> Table:
    rows = [
        (r["effect"], _words(r["right"]), _words(r["in_set"]), _words(r["probability_of_truth"]))
        for r in own["by_effect"]
    ]
    return Table(["effect", "right verdict", "in the set", "probability on the truth"], rows)


def _strangers(own: Mapping[str, Any]) -> Table:
    return Table(
        ["effect", "verdict", "cases"],
        [(r["truth"], r["said"], r["count"]) for r in own.get("strangers", ())],
    )


def _confusion(own: Mapping[str, Any], forecast: Mapping[str, Any] | None) -> Table:
    """Counts of truth and verdict, beside the frozen forecast's probability of that verdict."""
    matrix = (forecast or {}).get("matrix") or {}
    totals: dict[str, int] = {}
    for row in own["confusion"]:
        totals[row["truth"]] = totals.get(row["truth"], 0) + row["count"]
    rows = []
    for row in own["confusion"]:
        expected = (matrix.get(row["truth"]) or {}).get(row["said"])
        rows.append((row["truth"], row["said"], row["count"], row["count"] / totals[row["truth"]],
                     "" if expected is None else float(expected)))  # fmt: skip
    return Table(["truth", "verdict", "cases", "share", "forecast"], rows)


def _bars(axes: Any, places: Sequence[int], items: Sequence[Mapping[str, Any]], colour: str) -> None:
    for place, item in zip(places, items, strict=True):
        if item["value"] is not None:
            low, high = item["interval"]
            axes.plot([low, high], [place, place], color=colour, linewidth=2)
            axes.plot([item["value"]], [place], "o", color=colour)


def _effects(own: Mapping[str, Any]) -> Picture:
    rows = sorted(own["by_effect"], key=lambda r: r["right"]["value"] or 0.0)
    found = sum(1 for r in rows if (r["right"]["value"] or 0.0) >= 0.5)
    with canvas(height=max(2.0, 0.28 * len(rows) + 1.0)) as (figure, axes):
        _bars(axes, range(len(rows)), [r["right"] for r in rows], BLUE)
        axes.set_yticks(range(len(rows)), [r["effect"].replace("_", " ") for r in rows])
        axes.set_xlim(-0.03, 1.03)
        axes.set_xlabel("share of right verdicts")
        caption = (
            f"{found} of {len(rows)} effects are named rightly in half of their cases or more. Bars: 90 %."
        )
        return picture(figure, "blind-effects", "Share of right verdicts by true effect", caption)


def _distances(own: Mapping[str, Any]) -> Picture:
    rows = [r for r in own["by_distance"] if r["right"]["value"] is not None]
    with canvas(height=2.6) as (figure, axes):
        _bars(axes, range(len(rows)), [r["right"] for r in rows], BLUE)
        labels = [
            f"{r['from']:g} to {r['to']:g}" if r["to"] is not None else f"above {r['from']:g}" for r in rows
        ]
        axes.set_yticks(range(len(rows)), labels)
        axes.set_xlim(-0.03, 1.03)
        axes.set_xlabel("share of right verdicts")
        axes.set_ylabel("distance / sd")
        last = _words(rows[-1]["right"]) if rows else "no case"
        caption = (
            "Single effects by how many standard deviations they lie from the base model once its constants "
            f"have moved; the farthest: {last}."
        )
        return picture(figure, "blind-distance", "Share of right verdicts by size of the effect", caption)


def _calibration(own: Mapping[str, Any]) -> Picture:
    bins = own["calibration"]["bins"]
    with canvas(height=3.4) as (figure, axes):
        axes.plot([0, 1], [0, 1], color=GREY, linewidth=1)
        for item in bins:
            low, high = item["right"]["interval"]
            axes.plot([item["stated"]] * 2, [low, high], color=VERMILION, linewidth=2)
            axes.plot([item["stated"]], [item["right"]["value"]], "o", color=VERMILION)
        axes.set_xlabel("probability that the verdict states")
        axes.set_ylabel("share that is right")
        caption = f"Mean distance from the diagonal: {_words(own['calibration'])}. Bars: 90 %."
        return picture(
            figure, "blind-calibration", "Stated probability against share of right verdicts", caption
        )
