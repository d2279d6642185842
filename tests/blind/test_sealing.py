"""Commitments bind, tell nothing, and answers open only for frozen verdicts."""

from __future__ import annotations

import json
import stat
from pathlib import Path
from typing import Any

import pytest

from eaclutch.blind import sealing
from eaclutch.blind.sizes import SIZES, size_of
from eaclutch.files import read_json, write_json
from eaclutch.records import InputError

ANSWER = {"case": "a", "kind": "single", "verdict": ["gap_tilt"]}


def test_sizes_are_those_that_were_promised() -> None:
    assert SIZES["blind_small"].cases == 12 and SIZES["blind_small"].raw == 2
    assert SIZES["blind"].cases >= 120
    long = SIZES["blind_long"]
    assert (long.none, long.unknown, long.singles, long.pairs) == (150, 60, 6 * 16, 30)
    with pytest.raises(InputError, match="none of the benchmark's"):
        size_of("tiny")


def test_a_drawn_plan_is_new_every_time_and_an_open_one_the_same() -> None:
    drawn = [sealing.draw_plan("blind_small", None, None) for _ in range(2)]
    assert drawn[0]["entries"] != drawn[1]["entries"]
    assert not drawn[0]["open_seed"]
    assert sealing.draw_plan("blind_small", 3, None) == sealing.draw_plan("blind_small", 3, None)


def test_case_names_tell_nothing() -> None:
    plan = sealing.draw_plan("blind_small", 3, None)
    assert [e["case"] for e in plan["entries"]] == [f"blind-small-{i:04d}" for i in range(12)]
    assert sum(e["raw"] for e in plan["entries"]) == 2


def test_a_commitment_hangs_on_answer_and_salt() -> None:
    first = sealing.commitment(ANSWER, "11")
    assert first == sealing.commitment(dict(reversed(ANSWER.items())), "11")
    assert first != sealing.commitment(ANSWER, "12")
    assert first != sealing.commitment(ANSWER | {"verdict": ["slow_drive"]}, "11")


@pytest.fixture
def sealed(tmp_path: Path) -> tuple[Path, Path]:
    public, hidden = tmp_path / "0.json", tmp_path / "answers" / "0.json"
    write_json(public, {"cases": {"a": {"commitment": sealing.commitment(ANSWER, "77"), "level": "tables"}}})
    sealing.write_secret(hidden, {"answers": {"a": {"salt": "77", "answer": ANSWER}}})
    return public, hidden


def test_answers_are_the_owners_alone(sealed: tuple[Path, Path]) -> None:
    assert stat.S_IMODE(sealed[1].stat().st_mode) == 0o600
    assert stat.S_IMODE(sealed[1].parent.stat().st_mode) == 0o700


def test_sealed_answers_open(sealed: tuple[Path, Path]) -> None:
    assert sealing.open_answers([sealed[0]], [sealed[1]]) == {"a": ANSWER}


def test_a_changed_answer_is_refused(sealed: tuple[Path, Path]) -> None:
    content = read_json(sealed[1])
    content["answers"]["a"]["answer"]["verdict"] = []
    write_json(sealed[1], content)
    with pytest.raises(InputError, match="not the sealed one"):
        sealing.open_answers([sealed[0]], [sealed[1]])


def test_a_missing_answer_is_refused(sealed: tuple[Path, Path]) -> None:
    write_json(sealed[1], {"answers": {}})
    with pytest.raises(InputError, match="no answer to a"):
        sealing.open_answers([sealed[0]], [sealed[1]])


def frozen_method(folder: Path, document: dict[str, Any]) -> dict[str, Any]:
    write_json(folder / "rival" / "a.json", document)
    return sealing.freeze(folder / "rival", ["a", "b"])


def test_a_verdict_changed_after_freezing_is_refused(tmp_path: Path) -> None:
    frozen = frozen_method(tmp_path, {"x": 1})
    assert list(sealing.check_frozen(frozen, tmp_path / "rival")) == ["a"]
    (tmp_path / "rival" / "a.json").write_text(json.dumps({"x": 2}))
    with pytest.raises(InputError, match="changed after"):
        sealing.check_frozen(frozen, tmp_path / "rival")


def test_verdicts_cannot_be_mended_once_the_answers_were_open(tmp_path: Path) -> None:
    record = tmp_path / "opened.json"
    first = frozen_method(tmp_path, {"x": 1})
    assert sealing.record_opening(record, [first]) == {"rival": first["whole"]}
    assert sealing.record_opening(record, [first]) == {"rival": first["whole"]}
    with pytest.raises(InputError, match="had other verdicts"):
        sealing.record_opening(record, [frozen_method(tmp_path, {"x": 2})])
    late = first | {"method": "latecomer", "whole": "ff"}
    assert "latecomer" not in sealing.record_opening(record, [late])


@pytest.mark.usefixtures("few_constants")
def test_what_is_public_of_a_sealed_batch_holds_no_answer(tmp_path: Path) -> None:
    plan = sealing.draw_plan("blind_small", 4, None)
    plan["entries"] = [e for e in plan["entries"] if e["kind"] == "single" and not e["raw"]][:1]
    public, hidden = sealing.seal_batch(plan, 0, tmp_path)
    [(case, content)] = hidden["answers"].items()
    effect = content["answer"]["verdict"][0]
    assert content["answer"]["truth"]["closure"] == {effect: 1.0}
    texts = [path.read_text() for path in tmp_path.rglob("*") if path.is_file()] + [json.dumps(public)]
    for word in (effect, str(plan["entries"][0]["seed"]), content["salt"], "contact_stiffness"):
        assert not any(word in text for text in texts), word
    assert public["cases"][case]["commitment"] == sealing.commitment(content["answer"], content["salt"])
