"""Cases: made from a seed alone, shaped as the contract says, and the same at both levels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from eaclutch.blind.case import Case, build_case
from eaclutch.blind.generate import tables_of, write_tables
from eaclutch.blind.observe import runs_table
from eaclutch.blind.plan import Entry, generator, make_plan
from eaclutch.blind.rawlogs import lose_lines, record, write_bursts
from eaclutch.config import load_bench
from eaclutch.rig.extract import extract
from eaclutch.rig.load_cell import bursts_of
from eaclutch.rig.table import runs_table as library_table


@pytest.fixture(scope="module")
def case() -> Case:
    return build_case(Entry("plain", "test", 5, "none", ()))


@pytest.fixture(scope="module")
def table(case: Case) -> pd.DataFrame:
    return runs_table(case)


def test_a_seed_gives_the_same_case_bit_for_bit(case: Case, table: pd.DataFrame) -> None:
    again = runs_table(build_case(Entry("another-name", "test", 5, "none", ())))
    pd.testing.assert_frame_equal(again, table)


def test_namespaces_never_share_a_stream() -> None:
    draws = {space: generator(space, 5, "plan").random(4).tolist() for space in ("dev", "sealed", "test")}
    assert len({tuple(values) for values in draws.values()}) == 3


def test_design_is_the_published_one_in_small(table: pd.DataFrame) -> None:
    assert len(table) == 60
    assert table["session"].nunique() == 3
    assert 19 <= table["condition"].nunique() <= 24  # a preload near a bin's edge may fall on either side
    swept = table[table["preload_n"] > 0.3]
    assert swept["session"].nunique() == 1  # confounded with its session, as published
    assert table["run"].is_unique


def test_the_folder_reads_back(case: Case, tmp_path: Path) -> None:
    write_tables(tables_of(case), tmp_path)
    bench = load_bench(tmp_path)
    assert max(bench.substrates["brass"].thickness) == pytest.approx(6e-3)
    columns = pd.read_csv(tmp_path / "runs.csv").columns
    row = extract(record(case, 0, faulty=False, rng=generator("test", 5, "x")), bench)
    # the generator's reading of a slip does not know of a zero that it does not know
    assert set(columns) == set(library_table([row], bench).columns) - {"slip_fraction_sd_zero_known"}


def test_tables_and_logs_tell_the_same(case: Case, table: pd.DataFrame, tmp_path: Path) -> None:
    write_tables(tables_of(case), tmp_path)
    bench = load_bench(tmp_path)
    chosen = [i for i, v in enumerate(case.design.voltage) if v >= 250][:6]
    rng = generator("test", 5, "logs")
    rows = library_table([extract(record(case, i, faulty=False, rng=rng), bench) for i in chosen], bench)
    own = table.set_index("run").loc[rows["run"]].reset_index()
    for name, allowed in (
        ("friction_before_n", 0.002),
        ("shear_capacity_n", 0.012),
        ("switch_off_force_n", 0.02),
        ("final_force_n", 0.004),
        ("release_time_50_s", 1.2e-4),
        ("release_time_90_s", 1.2e-4),
    ):
        difference = (rows[name] - own[name]).abs().dropna()
        assert len(difference) >= 5, name
        assert difference.median() < allowed, name


def test_lost_lines_slide_the_rest_left_and_leave_zeros() -> None:
    column = np.arange(1.0, 10001.0)
    shifted = lose_lines(column, 700, np.random.default_rng(3))
    assert len(shifted) == len(column)
    assert np.all(shifted[-700:] == 0)
    assert shifted[-701] == 10000.0
    assert np.count_nonzero(np.diff(shifted[:-700]) == 701) == 1


def test_bursts_of_the_bare_cell_show_its_constants(case: Case, tmp_path: Path) -> None:
    path = tmp_path / "20250101_10_00_00_calibrate_loadcell_damper_dx=0.1_speed=6mms.csv.xz"
    write_bursts(case.constants, path, np.random.default_rng(1))
    found = bursts_of(path)
    natural = np.sqrt(case.constants.stiffness / case.constants.mass) / (2 * np.pi)
    assert len(found) >= 8
    assert np.median([swing.frequency for swing in found]) == pytest.approx(natural, rel=0.01)


def test_plans_hold_what_was_asked_for_and_do_not_tell_by_order() -> None:
    plan = make_plan("test", 9, none=10, unknown=13, each_single=2, pairs=4, prefix="x")
    kinds = [entry.kind for entry in plan]
    assert [kinds.count(k) for k in ("none", "unknown", "single", "pair")] == [10, 13, 32, 4]
    assert len({name for entry in plan if entry.kind == "unknown" for name, _ in entry.effects}) == 13
    assert kinds[:10] != ["none"] * 10
    limited = make_plan("test", 9, none=0, unknown=0, each_single=1, pairs=0, limits={"gap_tilt": 0.2})
    size = next(dict(e.effects)["gap_tilt"] for e in limited if e.effects[0][0] == "gap_tilt")
    assert 0.4 <= size <= 0.8


def test_leaving_an_effect_out_leaves_everything_else(case: Case) -> None:
    entry = replace(case.entry, kind="single", effects=(("slow_stage", 1.0),))
    with_effect, without = build_case(entry), build_case(entry, leave_out=("slow_stage",))
    np.testing.assert_array_equal(without.motion.before, case.motion.before)
    np.testing.assert_array_equal(with_effect.runs.preload, without.runs.preload)
    assert not np.array_equal(
        with_effect.runs.knob("speed_factor", 1.0), without.runs.knob("speed_factor", 1.0)
    )
