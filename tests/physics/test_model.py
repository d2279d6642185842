"""The model at rest and its interface: equilibria by scipy, statuses, bad input, shapes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from eaclutch.physics import laws
from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import OBSERVABLES, PART, Status
from eaclutch.records import Bench, InputError, Pad, Substrate


def _at_rest(volt, freq, width, thick, bend=0.0):
    """(preload, gap before, gap driven, capacity) by quadrature and brentq, no table and no kernel."""
    strip = 8049.0 * 0.1 * width * thick
    film = 1780.0 * 24e-6 * 55.5e-3 * width
    preload = (0.15 - 9.81 * (0.173 * (strip + film) + 0.154 * film)) / (0.173 + 0.154)
    kappa = float(laws.permittivity(freq, 54.2, 4.0, 2.82e-6, 0.562))
    scale = 8.8541878128e-12 * 28 * 1.5e-3 * width / 8 * volt**2

    def balance(h, pull):
        average = laws.roughness_average(h, 24e-6 / kappa, 2.8e-6)
        lift = float(laws.contact_force(h, 5.4e14, 2.8e-6, 55.5e-3, width, bend))
        return lift - preload - 9.81 * film - pull * scale * average

    before = brentq(lambda h: balance(h, 0.0), 1e-6, 2e-5, xtol=1e-16)
    driven = brentq(lambda h: balance(h, 1.0), 1e-6, before, xtol=1e-16)
    lift = float(laws.contact_force(driven, 5.4e14, 2.8e-6, 55.5e-3, width, bend))
    return preload, before, driven, 0.281 * (9.81 * (film + strip) + preload) + 0.188 * lift


@pytest.mark.parametrize("bend", [0.0, -0.4, 0.6])
def test_gaps_and_capacity_against_the_definitions(model, runs, bend):
    conditions = runs(
        voltage=[300.0, 150.0], frequency=[1e3, 0.1], width=[2e-3, 6e-3], thickness=[2e-3, 3e-3]
    )
    p = model.predict(conditions, {"contact_law_bend": bend})
    for i, run in enumerate([(300, 1e3, 2e-3, 2e-3), (150, 0.1, 6e-3, 3e-3)]):
        preload, before, driven, capacity = _at_rest(*run, bend)
        assert p.state["preload"][0, i] == pytest.approx(preload, rel=1e-9)
        assert p.state["gap_before"][0, i] == pytest.approx(before, rel=1e-7)
        assert p.state["gap_driven"][0, i] == pytest.approx(driven, rel=1e-6)
        assert p.values["shear_capacity_n"][0, i] == pytest.approx(capacity - 0.15, rel=2e-6)


def test_driven_run_by_hand(model, runs):
    """Ramp k v, sawtooth slope zero on average, slip depth from the damping ratio, expected force in its middle."""
    p = model.predict(runs(dwell=0.01), {"slip_phase": 0.0})
    k, b, m = 18018.0, 0.4274, 0.0011004
    assert p.values["ramp_rate_n_s"][0, 0] == pytest.approx(k * 0.5e-3)
    strip, film = 8049.0 * 0.1 * 4e-6, 1780.0 * 24e-6 * 55.5e-3 * 2e-3
    static = p.values["shear_capacity_n"][0, 0] + 0.15
    base = p.state["preload"][0, 0] + 9.81 * (strip + film)
    kinetic = 0.173 * base + 0.154 * (static - 0.281 * base) / 0.188
    zeta = b / (2 * np.sqrt(k * m))
    bottom = kinetic - np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)) * (static - kinetic)
    assert p.values["switch_off_force_n"][0, 0] == pytest.approx(bottom, rel=1e-9)
    assert p.values["slip_fraction"][0, 0] == pytest.approx(1 - bottom / static, rel=1e-9)
    short = model.predict(runs(drive_duration=0.02))
    assert short.status["capacity"][0, 0] == Status.never_slips
    assert short.values["shear_capacity_n"][0, 0] == pytest.approx(k * 0.5e-3 * 0.02)


def test_the_stage_goes_on_after_the_level_that_a_release_is_counted_from(model, runs):
    """The force at switch-off is the median of 3 ms, in which the strip sticks to the moving stage: a release starts
    from a force 1.5 ms of the climb higher, and each time is that to the level counted from the median."""
    climb, level = 18018.0 * 0.5e-3 * 1.5e-3, 0.3
    moving, resting = runs(switch_off_force=level), runs(switch_off_force=level + climb, dwell=0.01)
    p = model.predict(moving)
    time = np.linspace(1e-9, 2e-3, 20001)
    force = model.history(resting, 0, {}, 3.0 + time)
    np.testing.assert_allclose(model.history(moving, 0, {}, 3.0 + time), force, atol=1e-9)
    for share in (10, 50, 90):
        crossed = level - 0.01 * share * (level - p.values["final_force_n"][0, 0])
        at = np.interp(-crossed, -force[: np.argmin(force)], time[: np.argmin(force)])
        assert p.values[f"release_time_{share}_s"][0, 0] == pytest.approx(at, abs=2e-7)
    early = model.predict(runs(switch_off_force=level, dwell=0.01)).values["release_time_10_s"][0, 0]
    assert p.values["release_time_10_s"][0, 0] > early + 1.5e-5
    own = [model.predict(runs(dwell=d)).values["switch_off_force_n"][0, 0] for d in (0.0, 0.0005, 0.01)]
    assert own[2] - own[0] == pytest.approx(climb) and own[2] - own[1] == pytest.approx(climb / 1.5)
    sliding = [model.predict(runs(voltage=0.0, dwell=d)).values["switch_off_force_n"] for d in (0.0, 0.01)]
    np.testing.assert_array_equal(*sliding)  # without a voltage nothing sticks


def test_a_larger_static_friction_falls_as_the_law_of_slips_says(model, runs):
    """All static friction a tenth higher, kinetic as it was: what the solver lets go against the closed form."""
    higher = model.predict(runs(), {"film_static": 1.1 * 0.188, "base_static": 1.1 * 0.281})
    typical = model.predict(runs())
    expected = laws.larger_slip(typical.values["slip_fraction"], 0.1, model.slip_overshoot({}))
    assert np.all(expected > typical.values["slip_fraction"] + 0.05)
    np.testing.assert_allclose(higher.values["slip_fraction"], expected, rtol=1e-9)
    without = ClutchModel(model.bench, tuple(name for name in BASE if name != "load_cell_dynamics"))
    assert without.slip_overshoot({}) == 0.0


def test_ramp_slopes_are_least_squares(model, runs):
    """The closed form against a fit to the sawtooth of the history."""
    conditions = runs(voltage=[120.0, 300.0])
    for index in (0, 1):
        p = model.predict(conditions)
        for name, low, high in (("ramp_rate_n_s", 2e-3, 20e-3), ("ramp_rate_late_n_s", 50e-3, 200e-3)):
            time = np.linspace(low, high, 4001)
            fitted = np.polyfit(time, model.history(conditions, index, {}, time), 1)[0]
            # slips of the history take a half period, those of the closed form none
            assert p.values[name][0, index] == pytest.approx(fitted, abs=1.2)


def test_a_delay_of_the_voltage_keeps_the_force_where_it_was(model, runs):
    """2 ms: a third of the early window is flat, which takes 7/27 of its slope; 0.5 ms lie before every window."""
    late = ClutchModel(model.bench, (*BASE, "trigger_latency"))
    names = ("ramp_rate_early_n_s", "ramp_rate_n_s", "ramp_rate_late_n_s")
    prompt = model.predict(runs()).values
    same, little, much, all_of_it = (
        late.predict(runs(), {"trigger_latency.delay": delay}).values for delay in (0.0, 0.5e-3, 2e-3, 5e-3)
    )
    for name in prompt:
        np.testing.assert_array_equal(same[name], prompt[name], err_msg=name)
    for name in names[:2]:
        assert little[name][0, 0] == pytest.approx(prompt[name][0, 0], rel=1e-9)
    assert much[names[0]][0, 0] == pytest.approx(20 / 27 * prompt[names[0]][0, 0], rel=1e-9)
    assert much[names[1]][0, 0] == pytest.approx(prompt[names[1]][0, 0], rel=1e-9)
    assert all_of_it[names[0]][0, 0] == pytest.approx(0.0, abs=1e-9)
    # with slips in the window: the line through the shifted sawtooth, point by point
    time = np.linspace(50e-3, 200e-3, 300_001)
    top = prompt["shear_capacity_n"][0, 0] + 0.15
    fall, rate = prompt["slip_fraction"][0, 0] * top, 18018.0 * 0.5e-3
    for delay, found in ((0.0, prompt), (2e-3, much), (5e-3, all_of_it)):
        force = 0.15 + rate * (time - delay)
        force = np.where(force < top, force, top - fall + np.mod(force - top, fall))
        assert found[names[2]][0, 0] == pytest.approx(np.polyfit(time, force, 1)[0], abs=1e-2)
    # and what a run too short to slip reaches
    short = late.predict(runs(drive_duration=0.02), {"trigger_latency.delay": 2e-3})
    assert short.values["shear_capacity_n"][0, 0] == pytest.approx(rate * 0.018)


def test_pull_in_and_never_slips_are_named(model, runs):
    soft = model.predict(runs(), {"contact_stiffness": 2e12})
    assert (soft.status["release"] == Status.pull_in).all() and np.isnan(
        soft.values["shear_capacity_n"]
    ).all()
    low = model.predict(runs(switch_off_force=0.05, dwell=0.01))
    assert low.status["release"][0, 0] == Status.never_slips
    assert low.values["final_force_n"][0, 0] == pytest.approx(0.05)
    assert np.isnan(low.values["release_time_90_s"][0, 0])
    assert model.predict(runs(voltage=0.0)).status["engagement"][0, 0] == Status.timed_out


def test_ok_values_are_finite(model, runs):
    rng = np.random.default_rng(4)
    n = 400
    conditions = runs(
        voltage=rng.uniform(50, 400, n),
        frequency=np.exp(rng.uniform(-2, 10, n)),
        friction_before=rng.uniform(0, 1, n),
    )
    p = model.predict(
        conditions,
        {"roughness_sd": rng.uniform(1e-6, 5e-6, (3, n)), "kappa_static": np.array([20.0, 50, 90])},
    )
    for name in OBSERVABLES:
        assert p.values[name].shape == (3, n)
        assert np.isfinite(p.values[name][p.status_of(name) == Status.ok]).all(), name
    assert all((status != Status.timed_out).all() for status in p.status.values())


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("film_thickness", -1e-6),
        ("cole_cole_exponent", 1.2),
        ("roughness_sd", 0.0),
        ("contact_stiffness", np.nan),
    ],
)
def test_bad_parameters_are_named_with_value_and_bounds(model, runs, name, value):
    with pytest.raises(InputError) as error:
        model.predict(runs(), {name: value})
    low, high = model.parameters[name].bounds
    assert (
        name in str(error.value)
        and f"{value:g}" in str(error.value)
        and f"[{low:g}, {high:g}]" in str(error.value)
    )
    p = model.predict(runs(), {name: [value, model.parameters[name].default]}, on_invalid="status")
    assert p.status["release"][:, 0].tolist() == [Status.invalid, Status.ok]
    alone = model.predict(runs())
    assert p.values["release_time_90_s"][1, 0] == alone.values["release_time_90_s"][0, 0]


def test_shapes_that_do_not_broadcast_are_refused(model, runs):
    conditions = runs(voltage=[200.0, 300.0])
    for wrong in ({"mass": np.ones((2, 3))}, {"mass": [1e-3] * 2, "damping": [0.4] * 3}, {"masss": 1e-3}):
        with pytest.raises(InputError):
            model.predict(conditions, wrong)
    with pytest.raises(InputError):
        model.predict(conditions, {}, ["sharpness"])
    with pytest.raises(InputError):
        ClutchModel(model.bench, ["no_such_effect"])


def test_missing_inputs_get_a_status(model, runs):
    p = model.predict(runs(friction_before=[np.nan, 0.15]))
    assert p.status["capacity"][0].tolist() == [Status.invalid, Status.ok]


def test_only_what_is_asked_for(model, runs):
    conditions = runs(voltage=[200.0, 300.0])
    every = model.predict(conditions)
    for name in ("shear_capacity_n", "engagement_time_s", "release_time_50_s"):
        assert np.array_equal(model.predict(conditions, {}, [name]).values[name], every.values[name])
    assert set(PART) == set(every.values)


def test_multiplier_forms(bench, runs):
    conditions = runs(voltage=[100.0, 200.0, 300.0])
    plain = ClutchModel(bench, force_multiplier_form="none").predict(conditions)
    linear = ClutchModel(bench)
    same = linear.predict(conditions)
    assert np.array_equal(plain.values["shear_capacity_n"], same.values["shear_capacity_n"])
    tilted = linear.predict(conditions, {"force_multiplier_slope": 1e-3}).values["shear_capacity_n"]
    assert np.sign(tilted - same.values["shear_capacity_n"]).tolist() == [[-1, 0, 1]]
    with pytest.raises(InputError, match="force multiplier"):
        linear.predict(conditions, {"force_multiplier_slope": -0.05})


def test_rough_surface_rules(bench, runs):
    published, clamped = (
        ClutchModel(bench, roughness_rule=rule).predict(runs()).values["shear_capacity_n"]
        for rule in ("published", "clamped")
    )
    assert (clamped < published).all()
    flat = ClutchModel(bench, [name for name in BASE if name != "surface_roughness"]).predict(runs())
    assert (flat.values["shear_capacity_n"] < clamped).all()


def test_capacitance_bench_and_permittivity(model):
    force = np.array([0.5, 2.0, 4.0])
    gap = [
        brentq(lambda h, f=f: float(laws.contact_force(h, 5.4e14, 2.8e-6, 60e-3, 2e-3)) - f, 1e-6, 2e-5)
        for f in force
    ]
    kappa = laws.permittivity(1e3, 54.2, 4.0, 2.82e-6, 0.562)
    expected = laws.capacitance(model.bench.pad, 2e-3, np.array(gap), kappa, 24e-6) + 1e-12
    assert model.capacitance(force, 2e-3, {"stray_capacitance": 1e-12})[0] == pytest.approx(
        expected, rel=1e-6
    )
    assert model.capacitance(force, 2e-3, {"roughness_sd": [2e-6, 3e-6]}).shape == (2, 3)
    assert model.permittivity([1e3, 1e6])[0] == pytest.approx(
        laws.permittivity(np.array([1e3, 1e6]), 54.2, 4.0, 2.82e-6, 0.562)
    )


def test_the_fixture_may_be_straight_where_the_clutch_is_tilted(bench):
    plain, tilted = ClutchModel(bench), ClutchModel(bench, (*BASE, "gap_tilt"))
    force = np.array([0.2, 1.0, 4.0])
    tilt = {"gap_tilt.angle": 2e-3, "gap_tilt.fixture_share": 0.0}
    np.testing.assert_array_equal(tilted.capacitance(force, 2e-3, tilt), plain.capacitance(force, 2e-3))
    half = tilted.capacitance(force, 2e-3, {**tilt, "gap_tilt.fixture_share": 0.5})
    np.testing.assert_array_equal(
        half, tilted.capacitance(force, 2e-3, {"gap_tilt.angle": 1e-3, "gap_tilt.fixture_share": 1.0})
    )
    assert (half < plain.capacitance(force, 2e-3)).all()  # the highest parts of a tilted film bear it


def test_the_fixture_may_stick_less_than_the_clutch(bench):
    plain, sticky = ClutchModel(bench), ClutchModel(bench, (*BASE, "surface_adhesion"))
    force = np.array([0.2, 1.0, 4.0])
    pull = {"surface_adhesion.pressure": 1e5, "surface_adhesion.fixture_share": 0.0}
    np.testing.assert_array_equal(sticky.capacitance(force, 2e-3, pull), plain.capacitance(force, 2e-3))
    half = sticky.capacitance(force, 2e-3, {**pull, "surface_adhesion.fixture_share": 0.5})
    np.testing.assert_array_equal(half, sticky.capacitance(force, 2e-3, {"surface_adhesion.pressure": 5e4}))
    assert (half > plain.capacitance(force, 2e-3)).all()


def test_parallel_plates(runs):
    """A plate of the comb's active area, at half the voltage, is the comb with its film sign for sign."""
    substrates = {"brass": Substrate(density=8049.0)}
    comb = Bench(name="comb", pad=Pad(overlap_length=42e-3), substrates=substrates)
    plate = Bench(name="plate", pad=Pad(type="parallel_plate", overlap_length=42e-3), substrates=substrates)
    values = [
        ClutchModel(bench).predict(runs(voltage=volt)).values["release_time_90_s"][0, 0]
        for bench, volt in ((comb, 300.0), (plate, 150.0))
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-9)
