"""Every effect through the solver: neutral is the base model bit by bit, draws and bounds end in a status."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from eaclutch.physics.effect import Effect
from eaclutch.physics.effects import BASE, CANDIDATES, EFFECTS, LOOKALIKES
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import PART, Status
from eaclutch.records import Bench, RunConditions, Substrate

BENCH = Bench("bench", substrates={"brass": Substrate(8338.5, 7.26e-4, 0.1, {2e-3: 2e-3, 6e-3: 3e-3})})
OPTIONAL = (*CANDIDATES, *LOOKALIKES)
every_candidate = pytest.mark.parametrize("effect", [EFFECTS[name] for name in OPTIONAL], ids=OPTIONAL)


@pytest.fixture(scope="module")
def runs() -> RunConditions:
    """Voltages, frequencies, widths and preloads over the rig's range, in three sessions; switch-off measured."""
    voltage, frequency, width, friction = np.array(
        [(300, 1000, 2, 0.05), (300, 0.1, 2, 0.05), (150, 1000, 2, 0.05), (100, 10, 2, 0.02), (300, 1e4, 6, 0.05),
         (300, 10, 2, 0.5), (300, 1000, 2, 0.3)], dtype=float,
    ).T  # fmt: skip
    n = len(voltage)
    one = RunConditions(
        run=tuple("abcdefg"), session=("s1",) * 3 + ("s2",) * 2 + ("s3",) * 2, condition=tuple("abcdefg"),
        substrate=("brass",) * n, voltage=voltage, frequency=frequency, width=width * 1e-3,
        thickness=np.full(n, 2e-3), friction_before=friction, switch_off_force=np.full(n, np.nan),
        drive_duration=np.full(n, 3.0), dwell=np.where(frequency > 1, 0.5 / frequency, 0.0), run_order=np.arange(n),
    )  # fmt: skip
    held = ClutchModel(BENCH).predict(one, {}, ("switch_off_force_n",)).values["switch_off_force_n"][0]
    return dataclasses.replace(one, switch_off_force=held)


def _named(effect: Effect, values) -> dict[str, np.ndarray]:
    return {f"{effect.name}.{name}": value for name, value in values.items()}


@every_candidate
def test_neutral_is_the_base_model(effect: Effect, runs: RunConditions):
    drawn = effect.draw(np.random.default_rng(1))
    neutral = {p.name: drawn[p.name] if p.neutral is None else p.neutral for p in effect.parameters}
    base = ClutchModel(BENCH).predict(runs, {})
    off = ClutchModel(BENCH, (*BASE, effect.name)).predict(runs, _named(effect, neutral))
    for name, values in base.values.items():
        np.testing.assert_array_equal(off.values[name], values, err_msg=name)


@pytest.mark.parametrize("name", BASE)
def test_a_base_effect_without_strength_is_one_that_is_left_out(name: str, runs: RunConditions):
    out = ClutchModel(BENCH, tuple(other for other in BASE if other != name)).predict(runs, {})
    off = ClutchModel(BENCH).predict(runs, {f"{name}.strength": 0.0})
    for observable, values in out.values.items():
        np.testing.assert_array_equal(off.values[observable], values, err_msg=observable)


def _check(predicted) -> None:
    for name, values in predicted.values.items():
        fine = predicted.status[PART[name]] == Status.ok
        assert np.isfinite(values[fine]).all(), name


@every_candidate
def test_draws_from_draw_and_anywhere_within_bounds_give_numbers_or_a_status(
    effect: Effect, runs: RunConditions
):
    rng = np.random.default_rng(2)
    drawn = [effect.draw(rng) for _ in range(10)]
    values = {p.name: [d[p.name] for d in drawn] for p in effect.parameters}
    for p in effect.parameters:  # both bounds, and the middle in between
        values[p.name] += [p.bounds[0], p.bounds[1], 0.5 * (p.bounds[0] + p.bounds[1])]
    model = ClutchModel(BENCH, (*BASE, effect.name))
    predicted = model.predict(
        runs, _named(effect, {n: np.array(v) for n, v in values.items()}), on_invalid="status"
    )
    _check(predicted)
    plausible = {part: status[:10] for part, status in predicted.status.items()}
    assert np.mean(plausible["capacity"] == Status.ok) > 0.7
    assert not np.any([status == Status.invalid for status in plausible.values()])


@every_candidate
def test_each_is_seen_by_something(effect: Effect, runs: RunConditions):
    """A plausible amount changes an observable by more than the rig's own doubt, or the bench's capacitance."""
    rng = np.random.default_rng(3)
    parameters = _named(
        effect, {n: np.array([effect.draw(rng)[n] for _ in range(8)]) for n in effect.draw(rng)}
    )
    model, base = ClutchModel(BENCH, (*BASE, effect.name)), ClutchModel(BENCH)
    doubt = {"shear_capacity_n": 0.02, "release_time_50_s": 2.5e-5, "ramp_rate_n_s": 0.4, "slip_fraction": 0.03,
             "final_force_n": 0.01, "release_time_90_s": 2.5e-5}  # fmt: skip
    with_effect = model.predict(runs, parameters, tuple(doubt), on_invalid="status").values
    without = base.predict(runs, {}, tuple(doubt)).values
    largest = max(np.nanmax(np.abs(with_effect[n] - without[n])) / doubt[n] for n in doubt)
    force = np.array([0.5, 2.0])
    bench = (
        np.abs(model.capacitance(force, 2e-3, parameters) - base.capacitance(force, 2e-3, {})).max() / 2e-13
    )
    assert max(largest, bench) > 3.0


def test_a_part_of_a_campaign_keeps_its_sessions(runs: RunConditions):
    """Offsets belong to the campaign's sessions, whatever runs are predicted together, and one run's history too."""
    model = ClutchModel(BENCH, (*BASE, "session_drift"))
    drift = {
        "session_drift.offset_2": 0.3,
        "session_drift.offset_3": -0.3,
        "session_drift.friction_share": 0.0,
    }
    whole = model.predict(runs, drift, ("shear_capacity_n",)).values["shear_capacity_n"]
    rows = np.array([6, 3])
    part = model.predict(runs.select(rows), drift, ("shear_capacity_n",)).values["shear_capacity_n"]
    np.testing.assert_array_equal(part, whole[:, rows])
    time = np.arange(0.0, 1.0, 1e-3)
    force = model.history(runs, 6, drift, time)
    assert force.max() - runs.friction_before[6] == pytest.approx(whole[0, 6], rel=0.01)


def test_what_gives_behind_the_sliding_face_slows_the_ramp_and_no_swing(runs: RunConditions):
    model = ClutchModel(BENCH, (*BASE, "series_compliance"))

    def given(compliance: float, share: float) -> dict[str, float]:
        return {"series_compliance.compliance": compliance, "series_compliance.film_share": share}

    none, mount, film = (
        model.predict(runs, given(c, s)).values for c, s in ((0.0, 0.0), (2e-5, 0.0), (2e-5, 1.0))
    )
    holds = none["ramp_rate_n_s"] > 3.0  # the others slip within the ramp's window
    assert np.count_nonzero(holds) == 5
    np.testing.assert_allclose(film["ramp_rate_n_s"][holds], mount["ramp_rate_n_s"][holds], rtol=1e-9)
    assert np.max(film["ramp_rate_n_s"][holds] / none["ramp_rate_n_s"][holds]) < 0.8
    assert np.nanmin(mount["release_time_90_s"] / none["release_time_90_s"]) > 1.05
    # the stage rests before the release: what gives changes how far the force climbs in the last milliseconds
    resting = dataclasses.replace(runs, dwell=np.full(len(runs), 0.05))
    still, sheared = (model.predict(resting, given(c, 1.0)).values for c in (0.0, 2e-5))
    np.testing.assert_array_equal(sheared["release_time_90_s"], still["release_time_90_s"])
    force = model.history(runs, 0, given(2e-5, 1.0), np.array([4e-3, 16e-3]))
    assert (force[1] - force[0]) / 12e-3 == pytest.approx(film["ramp_rate_n_s"][0, 0], rel=0.02)
