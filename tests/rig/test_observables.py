"""The extractor against runs whose truth is known: values, uncertainties that cover, and stated responses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eaclutch.records import Bench, Substrate
from eaclutch.rig.extract import extract
from eaclutch.rig.observables import OBSERVABLES, PHASES
from rig.made_run import Made, make_run, release_time, without_lines

BENCH = Bench("test", substrates={"brass": Substrate(thickness={2e-3: 2e-3})})


def extracted(made: Made, seed: int) -> dict:
    return extract(make_run(made, np.random.default_rng(seed))[0], BENCH)


def truth(made: Made) -> dict[str, float]:
    most = made.capacity + made.friction - made.final
    return {
        "friction_before_n": made.friction,
        "engagement_time_s": made.onset,
        "ramp_rate_n_s": made.ramp,
        "ramp_rate_early_n_s": made.ramp,
        "switch_off_force_n": made.friction + made.hold,
        "start_ratio": (made.friction + made.hold - made.final) / most,
        "release_time_10_s": release_time(made, 0.1),
        "release_time_50_s": release_time(made, 0.5),
        "release_time_90_s": release_time(made, 0.9),
        "final_force_n": made.final,
        "baseline_shift_n": made.final - made.friction,
        "shear_capacity_n": made.capacity,
    }


def test_contract_has_all_its_observables():
    expected = set(truth(Made())) | {
        "ramp_rate_late_n_s", "slip_fraction", "hold_creep_n_s", "ringdown_frequency_hz", "ringdown_damping_ratio"
    }  # fmt: skip
    assert set(OBSERVABLES) == expected
    for name, observable in OBSERVABLES.items():
        info = observable.info
        assert info.name == name and info.phase in PHASES and info.unit and len(info.definition) > 15


@pytest.mark.parametrize("frequency", [0.1, 10.0, 1000.0])
def test_intervals_cover_the_truth(frequency):
    """68 % and 95 % intervals, over runs of several shapes; 30 runs and 12 observables a frequency."""
    rng = np.random.default_rng(int(frequency * 10))
    pulls = []
    for seed in range(30):
        made = Made(
            frequency=frequency,
            onset=rng.uniform(0, 1e-3),
            ramp=rng.uniform(5, 9),
            capacity=rng.uniform(0.3, 0.8),
            delay=rng.uniform(0.3e-3, 0.5e-3),
            fall=rng.uniform(0.6e-3, 1.0e-3),
            mains=rng.uniform(0, 2e-3),
            grounded_first=bool(seed % 2),
        )
        made = replace(made, hold=made.capacity * 0.9)
        found = extracted(made, seed)
        for name, value in truth(made).items():
            pulls.append((name, (found[name] - value) / found[f"{name}_sd"]))
    all_pulls = np.array([pull for _, pull in pulls])
    assert np.isfinite(all_pulls).all()
    assert 0.62 <= np.mean(np.abs(all_pulls) < 0.9945) <= 0.76
    assert 0.92 <= np.mean(np.abs(all_pulls) < 1.96) <= 0.985
    for name in truth(Made()):
        own = np.array([pull for other, pull in pulls if other == name])
        assert np.mean(np.abs(own) < 1.96) > 0.83, name
        assert abs(own.mean()) < 0.75, (name, own.mean())


@pytest.mark.parametrize(
    ("observable", "field", "change", "response"),
    [
        ("engagement_time_s", "onset", 2e-3, 1.0),
        ("release_time_50_s", "delay", 0.3e-3, 1.0),
        ("release_time_90_s", "delay", 0.3e-3, 1.0),
        ("release_time_90_s", "fall", 0.4e-3, np.arccos(-0.8) / np.pi),
        ("shear_capacity_n", "capacity", 0.2, 1.0),
        ("ramp_rate_n_s", "ramp", 3.0, 1.0),
        ("final_force_n", "final", 0.05, 1.0),
        ("friction_before_n", "friction", 0.1, 1.0),
    ],
)
def test_shifted_truth_moves_the_observable(observable, field, change, response):
    before = Made(capacity=0.5, hold=0.5, onset=0.5e-3)
    after = replace(before, **{field: getattr(before, field) + change})
    moves, sds = [], []
    for seed in range(6):
        first, second = extracted(before, seed), extracted(after, seed)
        moves.append(second[observable] - first[observable])
        sds.append(np.hypot(first[f"{observable}_sd"], second[f"{observable}_sd"]))
    tolerance = 3.0 * np.mean(sds) / np.sqrt(len(moves))
    assert np.mean(moves) == pytest.approx(response * change, abs=tolerance)
    assert tolerance < 0.8 * abs(change)


def test_zero_is_taken_off_where_it_shows_and_said_where_not():
    shown = extracted(Made(zero=0.04, contact=0.4), 1)
    assert "no_zero" not in shown["flags"]
    assert shown["friction_before_n"] == pytest.approx(0.12, abs=5 * shown["friction_before_n_sd"])
    hidden = extracted(Made(zero=0.04), 1)
    assert "no_zero" in hidden["flags"].split(";")
    assert hidden["friction_before_n"] == pytest.approx(0.16, abs=5 * hidden["friction_before_n_sd"])
    assert hidden["baseline_shift_n"] == pytest.approx(-0.02, abs=0.003)


def test_free_swing_is_found_with_its_frequency_and_absent_where_there_is_none():
    rung = extracted(Made(swing=0.25), 2)
    assert abs(rung["ringdown_frequency_hz"] - 640.0) < 3 * rung["ringdown_frequency_hz_sd"] + 1.0
    assert abs(rung["ringdown_damping_ratio"] - 0.02) < 3 * rung["ringdown_damping_ratio_sd"]
    assert np.isnan(extracted(Made(swing=0.0), 2)["ringdown_frequency_hz"])


def test_creep_only_where_the_stage_rests():
    slow = extracted(Made(frequency=0.8, capacity=0.5, hold=0.5), 3)
    assert slow["dwell_s"] > 0.1
    assert abs(slow["hold_creep_n_s"]) < 4 * slow["hold_creep_n_s_sd"]
    fast = extracted(Made(), 3)
    assert np.isnan(fast["hold_creep_n_s"]) and "hold_creep_n_s:stage_moves_until_off" in fast["reasons"]


def test_no_release_and_no_voltage_are_reasons_and_not_numbers():
    still = extracted(Made(capacity=0.05, hold=0.01, final=0.12), 4)
    assert np.isnan(still["release_time_90_s"]) and "release_time_90_s:no_release" in still["reasons"]
    recording, _, _ = make_run(Made(frequency=0.1), np.random.default_rng(5))
    dead = extract(
        replace(recording, voltage=recording.voltage * 0 + 2.0, flag=np.maximum.accumulate(recording.flag)),
        BENCH,
    )
    assert not dead["usable"] and "no_voltage" in dead["flags"]


@pytest.mark.parametrize("where", ["before", "hold", "after"])
def test_lost_lines_leave_right_numbers_or_none(where):
    made = Made(frequency=0.1, capacity=0.5, hold=0.48)
    recording, on, off = make_run(made, np.random.default_rng(6))
    at = {"before": on - 1.2, "hold": 0.4 * on + 0.6 * off, "after": off + 0.5}[where]
    start = int(np.searchsorted(recording.time, at))
    found = extract(replace(recording, force=without_lines(recording.force, (start, 700))), BENCH)
    assert "force_lines_lost" in found["flags"]
    for name in (
        "release_time_50_s",
        "release_time_90_s",
        "shear_capacity_n",
        "switch_off_force_n",
        "final_force_n",
    ):
        assert abs(found[name] - truth(made)[name]) < 4.5 * found[f"{name}_sd"], name
    if where == "hold":
        assert np.isnan(found["slip_fraction"])


def test_lines_lost_in_two_places_leave_no_release_time():
    made = Made(frequency=0.1, capacity=0.5, hold=0.48)
    recording, on, off = make_run(made, np.random.default_rng(7))
    first, second = (int(np.searchsorted(recording.time, at)) for at in (0.5 * (on + off), off + 0.6))
    found = extract(
        replace(recording, force=without_lines(recording.force, (first, 300), (second, 250))), BENCH
    )
    assert np.isnan(found["release_time_90_s"]) and "force_not_in_step" in found["flags"]
    assert abs(found["engagement_time_s"] - made.onset) < 4 * found["engagement_time_s_sd"]
    assert found["shear_capacity_n"] == pytest.approx(0.5, abs=0.02)
    assert found["final_force_n"] == pytest.approx(0.10, abs=0.005)
