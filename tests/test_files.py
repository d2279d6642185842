"""Atomic writing and equal bytes for equal numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from eaclutch.files import atomic, read_json, read_table, write_csv, write_json
from eaclutch.records import Gaussian, InputError


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), atomic(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old"
    assert [item.name for item in tmp_path.iterdir()] == ["a.txt"]


def test_json_is_sorted_rounded_and_without_nan(tmp_path: Path) -> None:
    value = {
        "b": np.float64(1 / 3),
        "a": [np.int64(2), float("nan")],
        "c": Gaussian(1.0, 2.0),
        "d": np.bool_(True),
    }
    write_json(tmp_path / "new" / "a.json", value)
    text = (tmp_path / "new" / "a.json").read_text()
    assert read_json(tmp_path / "new" / "a.json") == {
        "a": [2, None], "b": 0.333333333, "c": {"mean": 1.0, "sd": 2.0}, "d": True,
    }  # fmt: skip
    assert text.index('"a"') < text.index('"b"') < text.index('"c"')


def test_last_bits_do_not_reach_the_file(tmp_path: Path) -> None:
    x = np.array([0.1, 0.7, 1e-6 / 3])
    write_csv(tmp_path / "a.csv", pd.DataFrame({"x": x, "ok": [True, False, True]}))
    write_csv(tmp_path / "b.csv", pd.DataFrame({"x": x * (1 + 4e-16), "ok": [True, False, True]}))
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert (tmp_path / "a.csv").read_text().splitlines()[:2] == ["x,ok", "0.1,true"]


def test_missing_values_are_empty_cells(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", pd.DataFrame({"x": [1.0, np.nan], "y": ["a", None]}))
    assert (tmp_path / "a.csv").read_text() == "x,y\n1,a\n,\n"


def test_names_are_read_as_they_were_written(tmp_path: Path) -> None:
    table = pd.DataFrame(
        {"session": ["01", "1", "NA", "null"], "flags": ["", "a", "", ""], "value": [1.0, np.nan, 3.0, 4.0]}
    )
    write_csv(tmp_path / "runs.csv", table)
    found = read_table(tmp_path / "runs.csv")
    assert list(found["session"]) == ["01", "1", "NA", "null"]
    assert list(found["flags"]) == ["", "a", "", ""]
    assert found["value"].isna().tolist() == [False, True, False, False]


def test_what_is_no_table_is_named(tmp_path: Path) -> None:
    (tmp_path / "empty.csv").write_text("")
    assert read_table(tmp_path / "empty.csv").empty
    (tmp_path / "runs.csv").write_text('a,b\n1,2\n"3,4\n5,6,7,8')
    with pytest.raises(InputError, match=r"runs\.csv"):
        read_table(tmp_path / "runs.csv")
