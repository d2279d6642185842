"""Scores: a perfect oracle, a know-nothing, a liar, and files that are no verdicts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from eaclutch.blind.outcome import outcome, right_answer
from eaclutch.blind.scoring import score, scores, share
from eaclutch.files import plain
from eaclutch.records import InputError
from eaclutch.reporting.blind_page import blind_page

SCHEMAS = Path(__file__).resolve().parents[2] / "workflow" / "schemas"
NAMES = ("gap_tilt", "slow_drive", "gas_slip", "contact_aging")


def answer(kind: str, effects: list[str]) -> dict[str, Any]:
    true = {"unknown": ["unknown"]}.get(kind, sorted(effects))
    closure = {"+".join(sorted(effects)): 1.0} if effects else {}
    place = {"observable": "release_time_50_s", "phase": "release", "share": 0.6, "direction": "+",
             "factors": {"all": 0.2, "frequency_hz": 0.9, "session": 0.85}}  # fmt: skip
    return {
        "kind": kind,
        "effects": [{"effect": name, "size": 1.0} for name in effects],
        "verdict": true,
        "parameters": {"contact_stiffness": 5e14, "roughness_sd": 2.8e-6},
        "truth": {"distance_calibrated": 12.0, "closure": closure, "where": [place] if effects else []},
    }


def verdict(
    said: list[str], probability: float, others: dict[tuple[str, ...], float] | None = None
) -> dict[str, Any]:
    hypotheses = [{"effects": said, "probability": probability}]
    hypotheses += [{"effects": list(k), "probability": v} for k, v in (others or {}).items()]
    return {
        "hypotheses": hypotheses,
        "verdict": {"effects": said, "probability": probability, "alternatives": []},
        "where": [{"observable": "release_time_90_s", "factor": "session", "phase": "release", "share": 0.5,
                   "confounded_with": []}],
        "closure": {"shrinkage": 0.95, "interval": [0.8, 1.05]},
    }  # fmt: skip


def campaign() -> dict[str, dict[str, Any]]:
    cases = {f"n{i}": answer("none", []) for i in range(4)}
    cases |= {f"s{i}": answer("single", [name]) for i, name in enumerate(NAMES)}
    cases |= {"u0": answer("unknown", ["dust"]), "p0": answer("pair", ["gap_tilt", "slow_drive"])}
    return cases


def test_an_oracle_is_right_throughout() -> None:
    answers = campaign()
    said = {case: verdict(a["verdict"], 1.0) for case, a in answers.items()}
    found = score(answers, {"oracle": said}, {})["methods"]["oracle"]
    assert found["right"]["value"] == found["first_two"]["value"] == found["set_holds_truth"]["value"] == 1.0
    assert found["brier"]["value"] == found["log_score"]["value"] == found["calibration"]["error"] == 0.0
    assert found["false_alarms"]["value"] == found["wrong_name_on_unknown"]["value"] == 0.0
    assert found["where"]["observable"]["value"] == found["where"]["factor"]["value"] == 1.0
    assert found["closure"]["covered"]["count"] == 5
    assert found["closure"]["error"]["value"] == pytest.approx(-0.05)
    low, high = found["right"]["interval"]
    assert 0.7 < low < high == 1.0


def test_a_liar_is_wrong_where_it_matters() -> None:
    answers = campaign()
    said = {case: verdict(["film_tension"], 0.9, {(): 0.1}) for case in answers}
    found = scores([outcome(case, answers[case], said[case], {}, "liar") for case in answers])
    assert found["right"]["value"] == 0.0
    assert found["false_alarms"]["value"] == found["wrong_name_on_unknown"]["value"] == 1.0
    assert found["first_two"]["count"] == 4  # nothing came second, and nothing it was four times
    assert found["calibration"]["error"] == pytest.approx(0.9)
    assert found["closure"]["covered"]["of"] == 0
    assert {"truth": "none", "said": "film_tension", "count": 4} in found["confusion"]
    assert found["strangers"] == [{"truth": "dust", "said": "film_tension", "count": 1}]
    assert found["set_holds_truth_by_kind"]["none"]["count"] == 0


def test_an_effect_that_was_taken_out_of_the_library_is_unknown_to_it() -> None:
    single = answer("single", ["gap_tilt"])
    assert right_answer(single, "without-gap_tilt") == {"unknown"}
    assert right_answer(single, "without-slow_drive") == {"gap_tilt"}


def test_errors_of_parameters_count_in_posterior_sd() -> None:
    given = {"before": {"contact_stiffness": {"mean": 7e14, "sd": 1e14}},
             "after": {"contact_stiffness": {"mean": 5.5e14, "sd": 1e14}}}  # fmt: skip
    row = outcome("a", answer("single", ["gap_tilt"]), verdict(["gap_tilt"], 0.8), {"parameters": given}, "m")
    assert row["contact_stiffness_error_before"] == pytest.approx(2.0)
    assert row["contact_stiffness_error_after"] == pytest.approx(0.5)
    assert row["roughness_sd_error_after"] is None


def test_a_file_that_is_no_verdict_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"rival/a.json.*not a diagnosis.json"):
        outcome("a", answer("none", []), {"hypotheses": "all"}, {}, "rival")


def test_a_share_of_nothing_is_no_number() -> None:
    assert share([], "right") == {"value": None, "interval": None, "count": 0, "of": 0}


def test_only_effects_of_the_forecast_count_as_identifiable() -> None:
    answers = campaign()
    said = {case: verdict(a["verdict"] if case != "s1" else [], 0.8) for case, a in answers.items()}
    forecast = {"identifiable": ["gap_tilt", "slow_drive", "never_drawn"], "matrix": {"none": {"none": 0.97}}}
    document = score(answers, {"library": said}, {}, forecast)
    found = document["methods"]["library"]["identifiable"]
    assert found["first"]["count"] == 1 and found["first"]["of"] == 2
    assert found["effects"] == ["gap_tilt", "slow_drive"]
    document["methods"]["library"] |= {"frozen": "ab" * 32, "after_opening": True}
    page = blind_page(document)
    assert "0.97" in page and "after the answers were opened" in page


def test_the_score_keeps_to_its_schema() -> None:
    answers = campaign()
    said = {case: verdict(a["verdict"], 0.8, {(): 0.2}) for case, a in answers.items() if a["kind"] != "pair"}
    document = score(answers, {"library": said}, {})
    document["methods"]["library"] |= {"frozen": "ab" * 32, "after_opening": False}
    assert document["methods"]["library"]["missing"] == ["p0"]
    schema = yaml.safe_load((SCHEMAS / "blind_score.schema.yaml").read_text(encoding="utf-8"))
    jsonschema.validate(plain(document), schema, cls=jsonschema.Draft202012Validator)


def test_the_page_says_what_the_score_says_and_escapes_names() -> None:
    answers = campaign()
    said = {case: verdict(["<script>"], 0.5) for case in answers}
    document = score(answers, {"library": said}, {})
    document["methods"]["library"] |= {"frozen": "ab" * 32, "after_opening": False}
    page = blind_page(document)
    assert "10 campaigns whose cause was withheld: 4 with no effect" in page
    assert "<script>" not in page and "&lt;script&gt;" in page
    assert "0 of 10" in page
