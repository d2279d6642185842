"""How far a gap closes: the contract's formula, and an interval that says what noise leaves open."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse

from eaclutch.diagnosis.cells import Cells
from eaclutch.diagnosis.closure import _interval, _share, gap_numbers, surely_left, widened
from eaclutch.diagnosis.settings import load_thresholds

CONDITIONS, REPEATS = 20, 3
N = CONDITIONS * REPEATS
CELLS = Cells(
    np.array(["release_time_50_s"] * N, dtype=object),
    np.repeat([f"c{i}" for i in range(CONDITIONS)], REPEATS).astype(object),
    np.ones(N), sparse.identity(N, format="csr"), np.ones(N), np.zeros(N, dtype=bool), np.ones(N),
)  # fmt: skip
FLOORS = np.random.default_rng(0).chisquare(N, 400) / N


def numbers(gap: float, left: float, seed: int) -> dict:
    """Closure where a gap of ``gap`` noise sds (its sign differs by condition) closes to ``left``."""
    rng = np.random.default_rng(seed)
    noise, sign = rng.standard_normal(N), np.repeat(rng.choice([-1.0, 1.0], CONDITIONS), REPEATS)
    before, after = (SimpleNamespace(errors_left_out=size * sign + noise) for size in (gap, left))
    return gap_numbers(CELLS, before, after, FLOORS, np.random.default_rng(seed + 1))


def test_shrinkage_is_the_contracts_and_lies_in_its_interval():
    found = numbers(3.0, 1.0, 1)
    expected = (found["before"] - found["after"]) / (found["before"] - found["noise_floor"])
    assert found["shrinkage"] == pytest.approx(expected)
    assert found["interval"][0] <= found["shrinkage"] <= found["interval"][1]


@pytest.mark.parametrize(("left", "truth"), [(0.0, 1.0), (1.0, 8 / 9), (2.0, 5 / 9)])
def test_intervals_cover_the_share_that_was_closed(left, truth):
    held = [numbers(3.0, left, 2 * seed) for seed in range(60)]
    covered = np.mean([d["interval"][0] <= truth <= d["interval"][1] for d in held])
    assert covered >= 0.8  # of 90 % intervals: fewer than 48 of 60 would be a chance of 1 %
    assert np.median([d["interval"][1] - d["interval"][0] for d in held]) < 0.35


def test_a_gap_that_noise_may_have_made_leaves_everything_open():
    found = numbers(0.2, 0.2, 5)
    assert found["interval"][0] <= 0.0 and found["interval"][1] >= 1.0


def test_what_is_surely_left_holds_at_nearly_all_conditions():
    def result(name, sizes):
        return SimpleNamespace(effects=(name,) if name else (), errors_left_out=np.repeat(sizes, REPEATS))

    base = result("", np.full(CONDITIONS, 2.0))
    one_bad = np.full(CONDITIONS, 1.5)
    one_bad[0] = 30.0  # wider on average, by a single condition
    tried = [
        result("narrower", np.full(CONDITIONS, 1.0)), result("one_bad", one_bad),
        result("wider", np.full(CONDITIONS, 2.5)), base,
    ]  # fmt: skip

    study = SimpleNamespace(cells=CELLS, generator=np.random.default_rng)
    left = surely_left(study, tried)
    assert left[()] == pytest.approx(1.0)
    assert left[("narrower",)] == pytest.approx(0.25) and left[("wider",)] == pytest.approx(2.5**2 / 2.0**2)
    assert left[("one_bad",)] == pytest.approx(1.5**2 / 2.0**2, rel=1e-6)  # draws without that condition


def test_a_single_condition_says_nothing_of_others():
    alone = SimpleNamespace(
        condition=np.array(["c0"] * 3, dtype=object), errors=lambda e: e, variance=np.ones(3)
    )
    alone.level = np.zeros(3)
    study = SimpleNamespace(cells=alone, generator=np.random.default_rng)
    tried = [
        SimpleNamespace(effects=e, errors_left_out=np.full(3, s)) for e, s in (((), 1.0), (("worse",), 9.0))
    ]
    assert surely_left(study, tried) == {(): 0.0, ("worse",): 0.0}
    alone.observable = np.array(["release_time_50_s"] * 3, dtype=object)
    before, after = (SimpleNamespace(errors_left_out=np.full(3, size)) for size in (9.0, 3.0))
    found = gap_numbers(alone, before, after, FLOORS, np.random.default_rng(1))
    assert found["interval"][0] <= 0.0 < found["shrinkage"] < 1.0 <= found["interval"][1]


def test_the_size_of_a_gap_at_one_condition_is_known_as_well_as_noise_lets_it():
    noise = np.random.default_rng(2).normal(4.0, 1.0, 400)
    low, high = _interval(20.0, np.full(100, 20.0), noise)
    assert 17.5 < low < 19.0 and 21.0 < high < 22.5
    low, high = _interval(20.0, np.array([10.0, 30.0]), noise)  # of several: by how they differ
    assert low < 12.0 and high > 28.0


def test_a_gap_that_widened_has_not_closed():
    closed, left = np.array([-1.0, -3.0, 1.0, -1.0]), np.array([0.5, 4.0, 1.0, -0.5])
    assert _share(closed, left, np.ones(4, dtype=bool), 0.0).tolist() == [0.0, -3.0, 0.5, 1.0]


def test_a_caveat_names_what_is_predicted_worse_with_a_name_than_without():
    names = np.repeat(["release_time_50_s", "shear_capacity_n"], CONDITIONS).astype(object)
    count = len(names)
    cells = Cells(
        names, np.tile([f"c{i}" for i in range(CONDITIONS)], 2).astype(object), np.ones(count),
        sparse.identity(count, format="csr"), np.ones(count), np.zeros(count, dtype=bool), np.ones(count),
    )  # fmt: skip
    study = SimpleNamespace(cells=cells, generator=np.random.default_rng, thresholds=load_thresholds())

    def result(effects, release, capacity):
        errors = np.repeat([release, capacity], CONDITIONS).astype(float)
        return SimpleNamespace(effects=effects, errors_left_out=errors)

    soft = ("series_compliance",)
    base, named = result((), 5.0, 2.0), result(soft, 1.0, 4.0)
    notes = widened(study, [base, named], soft)
    assert len(notes) == 1 and "shear_capacity_n" in notes[0] and "4 to 16" in notes[0]
    assert "release" not in notes[0]
    assert widened(study, [base, named], ()) == []
    assert widened(study, [base, named], ("unknown",)) == []
    little = result(soft, 1.0, 2.4)  # 1.44 times
    assert widened(study, [base, little], soft) == []
    uneven = result(soft, 1.0, 0.0)
    uneven.errors_left_out[-1] = 20.0  # by a single condition
    assert widened(study, [base, uneven], soft) == []
