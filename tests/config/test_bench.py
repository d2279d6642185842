"""campaign.yaml: published defaults, units, and one error line for what cannot be."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest

from eaclutch.config import load_bench
from eaclutch.records import Bench, Friction, InputError, LoadCell


def bench_of(folder: Path, text: str) -> Bench:
    folder.mkdir(exist_ok=True)
    (folder / "campaign.yaml").write_text(text)
    return load_bench(folder)


def test_what_is_left_out_takes_the_published_value_and_the_folder_names_the_campaign(tmp_path: Path) -> None:
    bench = bench_of(tmp_path / "bench-7", "")
    assert bench.name == "bench-7"
    assert bench.pad.film_thickness == pytest.approx(24e-6)
    assert bench.substrates["brass"].thickness[0.004] == pytest.approx(0.002)
    assert bench.friction == Friction() and bench.load_cell == LoadCell()
    assert bench.sessions is None


def test_units_become_si(tmp_path: Path) -> None:
    text = """
pad: {film_thickness_um: 30, electrode_length_mm: 2}
drive: {rise_10_90_us: 10}
substrates: {steel: {thickness_mm: {2: 0.5}, length_mm: 80}}
friction: {base: {static: [0.3, 0.01]}}
capacitance_fixture: {stray_capacitance_pf: 10.5}
stage_speed_mm_s: 1e0
"""
    bench = bench_of(tmp_path / "a", text)
    assert bench.pad.film_thickness == pytest.approx(30e-6) and bench.pad.electrode_length == pytest.approx(
        2e-3
    )
    assert bench.drive.rise_10_90 == pytest.approx(10e-6) and bench.stage_speed == pytest.approx(1e-3)
    assert dict(bench.substrates["steel"].thickness) == pytest.approx({2e-3: 0.5e-3})
    assert bench.friction.base_static.mean == 0.3 and bench.friction.film_static == Friction().film_static
    assert bench.fixture.stray_capacitance == pytest.approx(10.5e-12)


@pytest.mark.parametrize(
    ("span", "end"),
    [
        ("{name: a, from: 2024-11-03, to: 2024-11-03}", datetime(2024, 11, 3, 23, 59, 59, 999999)),
        ("{name: a, from: 20241103, to: 20241103_16_20_52}", datetime(2024, 11, 3, 16, 20, 52)),
        ("{name: a, from: 2024-11-03 08:00:00, to: 2024-11-03T16:20:52}", datetime(2024, 11, 3, 16, 20, 52)),
    ],
)
def test_sessions_take_dates_and_stamps(tmp_path: Path, span: str, end: datetime) -> None:
    sessions = bench_of(tmp_path / "a", f"sessions: [{span}]").sessions
    assert sessions is not None and sessions[0].end == end


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pad: {film_thickness_mm: 3}", ("pad.film_thickness_mm", "not a known key", "film_thickness_um")),
        ("pad: {film_thickness_um: 24 um}", ("pad.film_thickness_um", "number")),
        ("pad: {film_thickness_um: -1}", ("pad.film_thickness_um", "above 0")),
        ("stage_speed_mm_s: .nan", ("stage_speed_mm_s", "finite")),
        ("stage_speed_mm_s: .inf", ("stage_speed_mm_s", "finite")),
        ("name: ../up", ("name", "matches")),
        ("name: a\nname: b", ("row 2", "stands twice")),
        ("substrates: {brass: {thickness_mm: {2: 2, 2: 3}}}", ("row 1", "stands twice")),
        ("a: &x [1]\nb: *x", ("row 2", "alias")),
        ("name: !!python/object/apply:os.system [ls]", ("row 1", "tag")),
        ("name: [", ("row 1",)),
        ("- 1", ("not a mapping",)),
        ("friction: {base: {static: [0.2, 0]}}", ("friction.base.static[1]", "above 0")),
        ("friction: {base: {static: [0.2, 0.1, 3]}}", ("friction.base.static", "entries")),
        ("sessions: [{name: a, from: 2024-11-04, to: 2024-11-03}]", ("sessions[0]", "ends before")),
        (
            "sessions: [{name: a, from: 2024-11-03, to: 2024-11-05}, {name: b, from: 2024-11-05, to: 2024-11-06}]",
            ("sessions[1]", "overlaps"),
        ),
        ("sessions: [{name: a, from: yesterday, to: 2024-11-05}]", ("sessions[0].from", "neither")),
        ("exclude: {run: }", ("exclude.run",)),
        ("[" * 1000, ("nested",)),
    ],
)
def test_one_line_names_file_key_and_remedy(tmp_path: Path, text: str, words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as caught:
        bench_of(tmp_path / "a", text)
    line = str(caught.value)
    assert "\n" not in line and "campaign.yaml" in line
    for word in words:
        assert word in line


def test_size_is_bounded_and_links_stay_inside(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="larger"):
        bench_of(tmp_path / "a", "#" * 2_000_000)
    (tmp_path / "elsewhere.yaml").write_text("name: x")
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "campaign.yaml").symlink_to(tmp_path / "elsewhere.yaml")
    with pytest.raises(InputError, match="link out of"):
        load_bench(tmp_path / "b")


def test_a_missing_folder_or_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such campaign folder"):
        load_bench(tmp_path / "none")
    with pytest.raises(InputError, match=r"campaign\.yaml"):
        load_bench(tmp_path)
