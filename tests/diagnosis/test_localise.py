"""The place of a gap that was put there by hand, its share, and what the design confounds it with."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import minimize

from eaclutch.diagnosis.cells import Cells
from eaclutch.diagnosis.channels import CHANNELS
from eaclutch.diagnosis.localise import Explained, localise
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.splits import Split, confounded, settings_of, splits_of

PLACE = load_thresholds()["place"]
RUNS = 24


@pytest.fixture
def campaign():
    """24 conditions of one run each; the first half in session A at low frequency, the rest in B at high."""
    n = 2 * RUNS
    names = ("release_time_50_s", "release_time_90_s")
    late = np.arange(RUNS) >= RUNS // 2
    conditions = SimpleNamespace(
        voltage=np.tile([200.0, 300.0], RUNS // 2), frequency=np.where(late, 1000.0, 10.0),
        width=np.full(RUNS, 2e-3), thickness=np.full(RUNS, 2e-3), dwell=np.zeros(RUNS),
        run_order=np.arange(RUNS) % 5 * 1.0, __len__=lambda self: RUNS,
    )  # fmt: skip
    runs = type("Runs", (), {**vars(conditions), "__len__": lambda self: RUNS})()
    labels = [f"c{i:02d}" for i in range(RUNS)]
    data = SimpleNamespace(
        conditions=runs, run_entries=n, channels=tuple(c for c in CHANNELS if c.name in names),
        channel=np.repeat(np.array(names, dtype=object), RUNS), condition=np.array(labels * 2, dtype=object),
        session=np.tile(np.where(late, "B", "A"), 2).astype(object),
        average=sparse.identity(n, format="csr"), preload=np.full(RUNS, 0.1),
        block=np.full(n, "release", dtype=object), bench=SimpleNamespace(width=np.zeros(0)),
        noise_sd=np.full(n, 0.02), offset_sd=np.zeros(n),
    )  # fmt: skip
    cells = Cells(
        data.channel, data.condition, np.full(n, 1e-10), sparse.identity(n, format="csr"),
        np.ones(n), np.zeros(n, dtype=bool), np.full(n, 5e-4),
    )  # fmt: skip
    return data, cells, late


def all_left(shift):
    """An effect of which calibration takes up nothing."""
    return Explained(shift, shift, np.full(len(shift), 0.02))


def where(campaign, errors, seed=2):
    data, cells, _ = campaign
    rng = np.random.default_rng(seed)
    simulated = rng.normal(0.0, 0.02, (400, data.run_entries))
    return localise(data, cells, errors, simulated, rng, PLACE)


def test_a_slow_release_at_low_frequency_is_found_there_and_its_session_is_named(campaign):
    rng = np.random.default_rng(1)
    errors = rng.normal(0.0, 0.02, 2 * RUNS)
    errors[RUNS:][~campaign[2]] += 0.2
    rows = where(campaign, errors).rows
    assert len(rows) == 1
    row = rows[0]
    assert (row["observable"], row["phase"], row["direction"]) == ("release_time_90_s", "release", "+")
    assert {row["factor"], *row["confounded_with"]} >= {"frequency_hz", "session"}
    assert row["share"] > 0.9
    assert row["interval"][0] <= row["share"] <= row["interval"][1]


def test_a_gap_everywhere_is_called_all(campaign):
    rng = np.random.default_rng(1)
    errors = rng.normal(0.0, 0.02, 2 * RUNS)
    errors[:RUNS] -= 0.2
    row = where(campaign, errors).rows[0]
    assert (row["observable"], row["factor"], row["direction"]) == ("release_time_50_s", "all", "-")


def test_no_gap_has_no_place(campaign):
    found = [where(campaign, np.random.default_rng(s).normal(0.0, 0.02, 2 * RUNS), s).rows for s in range(20)]
    # one family-wise error of 5 % for the whole table: more than five of twenty would be a chance of 3e-4
    assert sum(bool(rows) for rows in found) <= 5


def test_the_place_of_a_named_effect_is_where_it_acts_however_small_its_gap(campaign):
    data, cells, late = campaign
    rng = np.random.default_rng(1)
    errors, explained = rng.normal(0.0, 0.02, 2 * RUNS), np.zeros(2 * RUNS)
    explained[:RUNS][late] = -0.01
    errors += explained
    simulated = rng.normal(0.0, 0.02, (400, data.run_entries))
    (row,) = localise(data, cells, errors, simulated, rng, PLACE, all_left(explained)).rows
    assert row["observable"] == "release_time_50_s"
    assert {row["factor"], *row["confounded_with"]} >= {"frequency_hz", "session"}
    assert row["direction"] == "-" and row["share"] == pytest.approx(1.0)
    assert row["p_value"] > 0.05  # noise alone would not have shown it, and the table says so


def test_the_direction_is_that_of_the_measured_errors_whatever_the_effect_would_do(campaign):
    data, cells, late = campaign
    rng = np.random.default_rng(1)
    errors, explained = rng.normal(0.0, 0.02, 2 * RUNS), np.zeros(2 * RUNS)
    explained[:RUNS][late], errors[:RUNS][late] = -0.1, 0.1
    simulated = rng.normal(0.0, 0.02, (400, data.run_entries))
    (row,) = localise(data, cells, errors, simulated, rng, PLACE, all_left(explained)).rows
    assert row["direction"] == "+"


def test_the_place_of_an_effect_is_the_split_that_says_most_of_it(campaign):
    """Two fifths of the runs there feel it four times as much: the half that acts is named, not where it acts most."""
    data, cells, late = campaign
    rng = np.random.default_rng(1)
    explained = np.zeros(2 * RUNS)
    explained[:RUNS][late] = np.where(data.conditions.run_order[late] < 1.5, 0.4, 0.1)
    errors = explained + rng.normal(0.0, 0.02, 2 * RUNS)
    simulated = rng.normal(0.0, 0.02, (400, data.run_entries))
    (row,) = localise(data, cells, errors, simulated, rng, PLACE, all_left(explained)).rows
    assert {row["factor"], *row["confounded_with"]} >= {"frequency_hz", "session"}
    assert row["share"] == pytest.approx(1.0)


def test_an_effect_that_acts_alike_everywhere_is_called_all(campaign):
    data, cells, _ = campaign
    rng = np.random.default_rng(1)
    explained = np.concatenate([rng.uniform(0.05, 0.15, RUNS), np.zeros(RUNS)])
    simulated = rng.normal(0.0, 0.02, (400, data.run_entries))
    (row,) = localise(data, cells, explained, simulated, rng, PLACE, all_left(explained)).rows
    assert row["factor"] == "all"


def test_a_side_that_holds_little_of_what_an_effect_does_is_no_place_of_it(campaign):
    """Calibration leaves most of it in three of 24 runs, while the other 21 are as far off."""
    data, cells, _ = campaign
    rng = np.random.default_rng(1)
    data.conditions.run_order = np.where(np.arange(RUNS) < 3, 1.0, 0.0)
    shift, left = np.zeros(2 * RUNS), np.zeros(2 * RUNS)
    shift[:RUNS], left[:3] = 0.3, 0.2
    simulated = rng.normal(0.0, 0.02, (400, data.run_entries))
    (row,) = localise(
        data, cells, shift, simulated, rng, PLACE, Explained(shift, left, np.full(2 * RUNS, 0.02))
    ).rows
    assert row["factor"] == "all" and row["share"] == pytest.approx(1.0)


def test_of_sessions_the_one_is_named_that_holds_most_of_what_an_effect_does(campaign):
    """What calibration leaves stands out in the first of three sessions, of ever larger effect on the others."""
    data, cells, _ = campaign
    session = np.arange(2 * RUNS) % RUNS % 3
    data.session = np.array(["a", "b", "c"])[session]
    shift, left = np.zeros(2 * RUNS), np.zeros(2 * RUNS)
    shift[:RUNS], left[:RUNS] = np.array([[0.0, 0.2, 0.3], [-0.2, 0.1, 0.1]])[:, session[:RUNS]]
    simulated = np.random.default_rng(1).normal(0.0, 0.02, (400, data.run_entries))
    (row,) = localise(
        data, cells, shift, simulated, np.random.default_rng(1), PLACE,
        Explained(shift, left, np.full(2 * RUNS, 0.02)),
    ).rows  # fmt: skip
    assert (row["factor"], row["level"]) == ("session", "c")
    assert row["share"] == pytest.approx(0.09 / 0.13)


def test_what_calibration_takes_up_of_an_effect_is_no_place_of_it(campaign):
    """A force that is a third larger everywhere, and more so at 300 V: a factor on the force follows the former."""
    data, cells, _ = campaign
    rng = np.random.default_rng(1)
    shift = np.zeros(2 * RUNS)
    shift[:RUNS] = np.where(data.conditions.voltage > 250, 0.40, 0.26)
    factor, noise = np.append(np.ones(RUNS), np.zeros(RUNS))[:, None], 0.02**2 * np.eye(2 * RUNS)
    simulated = rng.normal(0.0, 0.02, (400, data.run_entries))
    places = [
        localise(data, cells, shift, simulated, rng, PLACE, Explained.of(shift, jacobian, noise)).rows[0]
        for jacobian in (0.0 * factor, factor, 1e-3 * factor)
    ]
    # a factor that its prior holds within a thousandth follows nothing
    assert [row["factor"] for row in places] == ["all", "voltage_v", "all"]
    even = np.concatenate([np.full(RUNS, 0.3), np.zeros(RUNS)])
    even[:4] += 1e-4  # what is left of an even force is far below the repeats' noise, and names no place
    said = Explained.of(even, factor, noise)
    assert localise(data, cells, even, simulated, rng, PLACE, said).rows[0]["factor"] == "all"
    assert places[1]["level"] == ">200" and places[1]["share"] == pytest.approx(0.40**2 / (0.40**2 + 0.26**2))


def test_what_is_left_of_an_effect_is_what_a_refit_leaves():
    """The ridge's closed form against a minimiser's."""
    rng = np.random.default_rng(3)
    shift, jacobian, sd = rng.normal(size=9), rng.normal(size=(9, 3)), rng.uniform(0.3, 2.0, 9)
    refit = minimize(lambda u: np.sum(((shift - jacobian @ u) / sd) ** 2) + u @ u, np.zeros(3), tol=1e-12)
    left = Explained.of(shift, jacobian, np.diag(sd**2)).left
    assert left == pytest.approx(shift - jacobian @ refit.x, abs=1e-5)


def test_a_factor_that_says_which_side_a_run_is_on_is_named_though_no_cut_of_it_does():
    """DC and 10 kHz rest for less than a millisecond, 1 and 10 Hz longer: no cut over the frequency parts them so."""
    frequency = np.tile([0.1, 1.0, 10.0, 1e4], 6)
    order = np.arange(24.0)
    at_rest = Split("dwell_s", "<=0.001", np.isin(frequency, [0.1, 1e4]).astype(float))
    late = Split("width_mm", ">2", (order >= 7).astype(float))
    settings = {
        "frequency_hz": frequency,
        "run_order": order,
        "width_mm": late.member,
        "voltage_v": np.ones(24),
    }
    assert confounded(at_rest, settings, PLACE["confounded"]) == ["frequency_hz"]
    assert confounded(late, settings, PLACE["confounded"]) == ["run_order"]


def test_sessions_have_no_order():
    """Three of eight sessions that do not follow one another hold all high voltages."""
    session = np.repeat(np.arange(8.0), 6)
    high = Split("voltage_v", ">200", np.isin(session, [1, 4, 6]).astype(float))
    settings = {
        "session": session,
        "voltage_v": 200.0 + 100.0 * high.member,
        "width_mm": np.tile([1.0, 2.0, 3.0], 16),
    }
    assert confounded(high, settings, PLACE["confounded"]) == ["session"]


def test_a_session_a_run_explains_nothing():
    session = np.arange(24.0)
    high = Split("voltage_v", ">200", np.tile([0.0, 1.0], 12))
    assert (
        confounded(high, {"session": session, "voltage_v": 200.0 + 100.0 * high.member}, PLACE["confounded"])
        == []
    )


def test_averaged_settings_are_the_settings(campaign):
    """Weights of a mean that add to 1 but for a bit put no run on the wrong side of a cut."""
    data, _, _ = campaign
    runs = data.conditions
    runs.voltage = np.repeat([200.1, 233.3, 250.7, 300.3], 6)
    weights = np.random.default_rng(1).uniform(0.5, 2.0, (8, 3))
    average = np.zeros((8, RUNS))
    for i, share in enumerate(weights / weights.sum(axis=1, keepdims=True)):
        average[i, 3 * i : 3 * i + 3] = share
    assert len(np.unique(average @ runs.voltage)) > 4  # what a plain mean would take for levels
    few = SimpleNamespace(
        conditions=runs, average=sparse.csr_matrix(average), run_entries=8, session=np.array(["A"] * 8),
        preload=np.full(RUNS, 0.1),
    )  # fmt: skip
    assert len(np.unique(settings_of(few)["voltage_v"])) == 4
    low = next(s for s in splits_of(few) if s.factor == "voltage_v" and s.level == "<=233")
    assert low.member.tolist() == [1.0] * 4 + [0.0] * 4


def test_what_is_seen_on_the_bench_alone_has_its_place_there(campaign):
    """Capacitance readings of two strips, a tenth too small: none of the runs' observables, no factor of theirs."""
    data, cells, _ = campaign
    rng = np.random.default_rng(1)
    n, readings = data.run_entries, 8
    with_bench = SimpleNamespace(
        **vars(data)
        | {
            "block": np.append(data.block, [*["capacitance"] * readings, "permittivity"]),
            "bench": SimpleNamespace(width=np.append(np.repeat([2e-3, 4e-3], readings // 2), 0.0)),
            "noise_sd": np.full(n + readings + 1, 0.02),
            "offset_sd": np.zeros(n + readings + 1),
        }
    )
    errors = rng.normal(0.0, 0.02, n + readings + 1)
    explained = np.zeros(len(errors))
    explained[n : n + readings] = -0.1
    simulated = rng.normal(0.0, 0.02, (400, len(errors)))
    for known in (None, all_left(explained)):
        (row,) = localise(with_bench, cells, errors + explained, simulated, rng, PLACE, known).rows
        assert (row["observable"], row["phase"], row["factor"]) == ("capacitance_pf", "capacitance", "all")
        assert row["direction"] == "-" and row["share"] > 0.9 and row["p_value"] < 0.05
