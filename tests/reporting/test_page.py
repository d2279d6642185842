"""The page: it tells the verdict it was given, escapes what it was given, and stands alone."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from eaclutch.files import read_json, write_json
from eaclutch.records import InputError
from eaclutch.reporting.page import render
from eaclutch.reporting.results import read_results


def page(folder: Path, **verdict: object) -> str:
    path = folder / "diagnosis" / "diagnosis.json"
    document = read_json(path)
    document["verdict"] |= verdict
    write_json(path, document)
    return render(read_results(folder), {"seed": 5, "campaign": "/somewhere/private/bench-7"})


def heading(html: str) -> str:
    found = re.search(r"<h1[^>]*>(.*?)</h1>", html, flags=re.DOTALL)
    assert found
    return found.group(1).replace("\u00a0", " ")


class Structure(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.unnamed = 0
        self.outside: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if given.get("id"):
            self.ids.append(str(given["id"]))
        if tag == "a":
            self.links.append(str(given["href"]))
        if given.get("role") == "img" and not given.get("aria-label"):
            self.unnamed += 1
        for key in ("src", "href", "xlink:href"):
            if str(given.get(key, "")).startswith(("http", "//", "file")):
                self.outside.append(str(given[key]))
        assert tag != "script"


def test_the_first_screen_says_the_verdict_and_its_caveats(results_folder: Path) -> None:
    html = page(results_folder)
    assert heading(html) == (
        "The gap is explained by trapped charge (probability 88 %), which closes 89 % (80 % to 96 %) of "
        "what can be closed, on conditions that the fit did not see."
    )
    header = html[: html.index("</header>")].replace("\u00a0", " ")
    for words in (
        "varies together with session",
        "rests on its prior",
        "has not converged",
        "1 of 12 runs is not used (the voltage never came on)",
        "90 % release time at drive frequency ≤ 10 Hz lies above the prediction (61 % of the closable gap)",
        "that closes 89 % (80 % to 96 %) of what can be closed;",
    ):
        assert words in header
    assert "1.4" in html and "3.2 posterior sd" in html


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        (
            {"effects": []},
            "No gap that needs a missing effect (probability 88 %); the model misses by more than noise does "
            "(3.1 against 1.1), no further than its base laws may be off.",
        ),
        ({"effects": [], "alternatives": [["gap_tilt"]]}, "but gap tilt cannot be ruled out"),
        ({"effects": ["unknown"]}, "nothing in the library of effects explains it"),
        ({"effects": ["unknown"], "alternatives": [[]]}, "that there is no gap cannot be ruled out"),
        (
            {"alternatives": [["gap_tilt", "trapped_charge"]]},
            "whether gap tilt adds to it, these data cannot tell",
        ),
        (
            {"effects": ["gap_tilt", "trapped_charge"], "alternatives": [["trapped_charge"]]},
            "whether gap tilt is needed for that, these data cannot tell",
        ),
        ({"alternatives": [["contact_aging"]]}, "(probability 88 %), but contact aging cannot be ruled out"),
        (
            {"alternatives": [["contact_aging"]], "probability": 0.5},
            "(probability 50 %), but these data cannot tell it from contact aging",
        ),
        (
            {"effects": ["gap_tilt", "trapped_charge"], "alternatives": [["contact_aging"], ["gap_tilt"]]},
            "but contact aging or gap tilt alone cannot be ruled out",
        ),
        (
            {"alternatives": [[], ["contact_aging"]], "probability": 0.5},
            "cannot tell it from no gap or contact aging",
        ),
        (
            {"alternatives": [["contact_aging"], ["gap_tilt", "trapped_charge"]]},
            "but contact aging or gap tilt and trapped charge cannot be ruled out",
        ),
        ({"effects": ["trapped_charge", "gap_tilt"]}, "explained by trapped charge and gap tilt"),
    ],
)
def test_other_verdicts(results_folder: Path, verdict: dict, words: str) -> None:
    assert words in heading(page(results_folder, **verdict))


def test_a_third_effect_beside_the_pair_that_is_named_is_said_with_its_share(results_folder: Path) -> None:
    pair, three = ["gap_tilt", "trapped_charge"], ["air_gap", "gap_tilt", "trapped_charge"]
    path = results_folder / "diagnosis" / "diagnosis.json"
    document = read_json(path)
    document["hypotheses"] = [{"effects": three, "probability": 0.6}, {"effects": pair, "probability": 0.15}]
    write_json(path, document)
    said = heading(page(results_folder, effects=pair, probability=0.75, alternatives=[three, ["unknown"]]))
    assert said == (
        "The gap points to gap tilt and trapped charge (probability 75 %; 60 % with air gap besides), "
        "but these data cannot tell it from an effect outside the library."
    )
    # beside another verdict the three are a rival like any other
    said = heading(page(results_folder, effects=["unknown"], alternatives=[three]))
    assert "air gap and gap tilt and trapped charge cannot be ruled out" in said


def test_a_gap_at_the_noise_floor_is_none(results_folder: Path) -> None:
    path = results_folder / "diagnosis" / "diagnosis.json"
    document = read_json(path)
    document["gap"]["total"]["before"] = 1.9 * document["gap"]["total"]["noise_floor"]
    write_json(path, document)
    assert heading(page(results_folder, effects=[])) == (
        "No gap beyond repeatability: the model predicts what it has not seen as well as repeats allow "
        "(probability 88 %)."
    )


def test_an_effect_that_leaves_a_gap_explains_it_partly(results_folder: Path) -> None:
    path = results_folder / "diagnosis" / "diagnosis.json"
    document = read_json(path)
    document["causes"][0]["adequate_after"] = False
    write_json(path, document)
    html = page(results_folder)
    assert "The gap is partly explained by trapped charge" in heading(html)
    assert "part of the gap still stays unexplained" in html[: html.index("</header>")]


@pytest.mark.parametrize(("most", "left"), [(1.0, False), (0.7, True)])
def test_more_is_missing_only_where_noise_would_not_leave_as_much(
    results_folder: Path, most: float, left: bool
) -> None:
    path = results_folder / "diagnosis" / "diagnosis.json"
    document = read_json(path)
    document["closure"] |= {"shrinkage": 0.5, "interval": [0.1, most]}
    write_json(path, document)
    assert ("something else is missing" in page(results_folder)) is left


def test_the_page_stands_alone_and_its_links_lead_somewhere(results_folder: Path) -> None:
    html = page(results_folder)
    found = Structure()
    found.feed(html)
    assert len(found.ids) == len(set(found.ids))
    assert not found.outside and not found.unnamed
    assert all(link.removeprefix("#") in found.ids for link in found.links)
    for name in (
        "closure",
        "hypotheses",
        "by-observable",
        "where-0",
        "prediction-0",
        "coverage",
        "corner-contact",
        "trace-force",
    ):
        assert name in found.ids
    assert "/somewhere/private" not in html
    assert len(html) < 10_000_000


def test_a_stage_that_has_not_converged_is_marked(results_folder: Path) -> None:
    rows = re.findall(r'<tr class="bad">.*?</tr>', page(results_folder), flags=re.DOTALL)
    assert len(rows) == 1 and "force multiplier level" in rows[0]


def test_text_of_the_campaign_stays_text(results_folder: Path) -> None:
    evil = "<script>alert(1)</script>"
    runs = results_folder / "runs.csv"
    runs.write_text(runs.read_text().replace("no_voltage", evil).replace("run_03", f"run{evil}"))
    html = page(results_folder, why=evil)
    assert "<script" not in html and "&lt;script&gt;" in html


def test_without_runs_predictions_or_a_gap_there_is_still_a_page(results_folder: Path) -> None:
    (results_folder / "predict" / "runs.csv").write_text(
        "run,observable,q05,median,q95,measured,measured_sd,status,held_out\n"
    )
    document = read_json(results_folder / "diagnosis" / "diagnosis.json")
    empty = {
        "gap": {"total": None, "by_observable": {}},
        "where": [],
        "hypotheses": [],
        "causes": [],
        "closure": None,
        "absorbed": {},
    }
    write_json(results_folder / "diagnosis" / "diagnosis.json", document | empty)
    html = page(results_folder, effects=[], probability=None)
    assert "No gap beyond repeatability" in heading(html) and "<nan" not in html


def test_the_same_results_give_the_same_page(results_folder: Path) -> None:
    assert page(results_folder) == page(results_folder)


def test_what_is_missing_is_named(results_folder: Path) -> None:
    (results_folder / "predict" / "runs.csv").unlink()
    with pytest.raises(InputError, match=r"predict/runs\.csv"):
        read_results(results_folder)
