"""The compiled solver against scipy's implicit solution of the unreduced equations, and against its own claims."""

from __future__ import annotations

import numpy as np
import pytest
import solver_reference as reference
from scipy.integrate import solve_ivp
from solver_draws import draws

from eaclutch.physics.effects import BASE, EFFECTS
from eaclutch.physics.kernels import film, statics, tip
from eaclutch.physics.kernels.drive import RELEASING
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import Status
from eaclutch.physics.tables import tables

TIMES = ("release_time_10_s", "release_time_50_s", "release_time_90_s", "final_force_n")


def test_times_of_random_draws():
    model, conditions, parameters = draws(6, seed=11)
    p = model.predict(conditions, parameters)
    table, _ = model.rows(conditions, parameters)
    for i, row in enumerate(table[0]):
        time = reference.engagement(row, 0.005, "Radau", 1e-9)
        assert p.values["engagement_time_s"][0, i] == pytest.approx(time, rel=1e-4)
        status, results = reference.release(row, "Radau", 1e-9)
        assert p.status["release"][0, i] == status
        if status == Status.ok:
            ours = [p.values[name][0, i] for name in TIMES]
            assert ours[:3] == pytest.approx(results[:3].tolist(), rel=3e-4)
            assert ours[3] == pytest.approx(results[3], abs=2e-5)


# Effects that open a socket of the release, each at a value that changes it plainly.
OPENED = {
    "velocity_weakening": {"depth": 0.5, "speed": 0.02},
    "substrate_inertia": {"participation": 1.0},
    "series_compliance": {"compliance": 2e-5},
    "edge_wrap": {},
    "trapped_charge": {"residual_fraction": 0.4},
    "gas_slip": {},
    "film_tension": {"stiffness": 1e6, "hardening": 2e11, "free_gap": 9e-6},
    "surface_adhesion": {},
    "gap_tilt": {"angle": 4e-3, "levelling": 0.1, "air_share": 0.7},
    "contact_aging": {},
}


@pytest.mark.parametrize("name", OPENED)
def test_release_with_an_effect(name, runs, bench):
    model = ClutchModel(bench, (*BASE, name))
    rng = np.random.default_rng(7)
    values = EFFECTS[name].draw(rng) | OPENED[name]
    conditions = runs(voltage=250.0, frequency=10.0, switch_off_force=0.9, friction_before=0.1, dwell=0.05)
    parameters = {f"{name}.{key}": value for key, value in values.items()}
    p = model.predict(conditions, parameters)
    base = ClutchModel(bench).predict(conditions)
    status, results = reference.release(model.rows(conditions, parameters)[0][0, 0], "Radau", 1e-8)
    assert status == Status.ok == p.status["release"][0, 0]
    ours = [p.values[key][0, 0] for key in TIMES]
    assert ours[:3] == pytest.approx(results[:3].tolist(), rel=5e-4)
    assert ours[3] == pytest.approx(results[3], rel=5e-3, abs=1e-3)
    if name != "contact_aging":  # its static friction plays no part once the tip slides from the start
        assert ours[2] != pytest.approx(base.values[TIMES[2]][0, 0], rel=1e-6)


def test_side_walls_hold_more_while_the_voltage_is_on(runs, bench):
    """The pull's static friction adds to the capacity, and nothing once the voltage is off."""
    model, conditions = ClutchModel(bench, (*BASE, "edge_wrap")), runs(voltage=300.0, switch_off_force=0.9)
    wrap = {"edge_wrap.friction_per_preload": 0.3, "edge_wrap.damping_per_preload": 1.0}
    plain = model.predict(conditions, wrap)
    pulled = model.predict(conditions, {**wrap, "edge_wrap.pull_per_preload": 0.2})
    row = model.rows(conditions, {**wrap, "edge_wrap.pull_per_preload": 0.2})[0][0, 0]
    assert row["side_pull"] > 0.0
    more = pulled.values["shear_capacity_n"] - plain.values["shear_capacity_n"]
    assert more[0, 0] == pytest.approx(row["side_pull"] * row["film_static"] / row["film_kinetic"], rel=1e-6)
    assert pulled.values[TIMES[2]][0, 0] == plain.values[TIMES[2]][0, 0]


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_a_friction_that_falls_behind_its_load_holds_less_where_it_is_large(runs, bench, power):
    """F / (1 + (s F)^n)^(1 / n) of the whole static friction, and a small s changes nothing."""
    model, conditions = (
        ClutchModel(bench, (*BASE, "falling_friction")),
        runs(voltage=300.0, switch_off_force=0.5),
    )
    capacity = [
        model.predict(
            conditions, {"falling_friction.softening": soft, "falling_friction.power": power}
        ).values["shear_capacity_n"][0, 0]
        for soft in (0.0, 1e-9, 0.4)
    ]
    before = float(conditions.friction_before[0])
    whole = capacity[0] + before
    assert capacity[1] == pytest.approx(capacity[0], rel=1e-6)
    assert capacity[2] + before == pytest.approx(
        whole / (1.0 + (0.4 * whole) ** power) ** (1.0 / power), rel=1e-9
    )


def test_what_the_hold_loses_is_seen_at_release_alone(model, runs):
    """A fifth of the pull gone from the start, or by the end of the hold: the film is let go from the same gap."""
    model = ClutchModel(model.bench, (*BASE, "supply_sag"))
    conditions = runs(frequency=1e4, switch_off_force=0.5)
    sag = {"supply_sag.sag": 0.8**-0.5 - 1.0, "supply_sag.frequency_exponent": 1.0}
    whole = model.predict(conditions, sag | {"supply_sag.sag": 0.0})
    soon = model.predict(conditions, sag | {"supply_sag.late_share": 0.0})
    late = model.predict(conditions, sag | {"supply_sag.late_share": 1.0})
    assert late.values["shear_capacity_n"] == whole.values["shear_capacity_n"]
    assert soon.values["shear_capacity_n"] < 0.95 * whole.values["shear_capacity_n"]
    for name in TIMES:
        np.testing.assert_allclose(late.values[name], soon.values[name], rtol=1e-9)
        assert abs(late.values[name][0, 0] - whole.values[name][0, 0]) > 0
    # without a measured force at switch-off: it slips again as the hold's pull fades, and no more than the rest of it
    conditions = runs(frequency=1e4)
    for phase in (0.0, 0.5, 1.0):
        soon, late = (
            model.predict(conditions, sag | {"supply_sag.late_share": share, "slip_phase": phase})
            for share in (0.0, 1.0)
        )
        held = late.values["switch_off_force_n"]
        assert held <= (soon.values["shear_capacity_n"] + 0.15) * (1 + 1e-12)
        assert (held >= soon.values["switch_off_force_n"] * (1 - 1e-12)).all()


def test_film_step_has_order_four(model, runs):
    """Fixed steps over a smooth stretch of a release: the error falls as the fourth power of the step."""
    row = model.rows(runs(), {})[0][0, 0]
    preload, before = statics.rest_before(row, tables())
    _, driven = statics.driven_gap(row, preload, before, tables())
    load = preload + row["film_weight"]

    def end(steps):
        t, h, v, dt = 3e-6, driven + 2e-8, 0.02, 24e-6 / steps
        for _ in range(steps):
            slopes = film.net_force_slopes(row, t, h, v, load, before, RELEASING, tables())
            h, v, *_ = film.rodas_step(row, t, h, v, dt, slopes, load, before, RELEASING, tables())
            t += dt
        return h

    exact = end(3000)
    errors = np.array([abs(end(n) - exact) for n in (12, 24, 48, 96)])
    order = np.log2(errors[:-1] / errors[1:])
    assert order[-1] == pytest.approx(4.0, abs=0.4), (errors, order)


@pytest.mark.parametrize("damping", [0.43, 40.0])
@pytest.mark.parametrize("length", [1e-6, 2.4e-5, 2.6e-5, 1.5e-4])
def test_tip_segment_is_exact(damping, length):
    """Under a quintic force, short (power series) and long, under- and overdamped."""
    m, k = 1.1e-3, 18018.0
    force = np.array([0.8, -2.0, 1e4, -2e8, 1e12, -3e15])
    segment = np.zeros(tip.COLUMNS)
    tip.set_segment(segment, 0.0, length, 4e-5, -0.03, m, damping, k, force, 1.0)
    result = solve_ivp(
        lambda t, y: [y[1], (np.polynomial.polynomial.polyval(t, force) - damping * y[1] - k * y[0]) / m],
        (0.0, length), [4e-5, -0.03], rtol=1e-12, atol=1e-20, method="DOP853",
    )  # fmt: skip
    x, v = tip.oscillate(segment, length)
    assert (x, v) == pytest.approx(tuple(result.y[:, -1]), rel=1e-8, abs=1e-13)


def test_no_status_depends_on_the_tolerance():
    model, conditions, parameters = draws(1000, seed=3)
    loose = ClutchModel(model.bench, model.effects, tolerance=1e-4).predict(conditions, parameters)
    tight = ClutchModel(model.bench, model.effects, tolerance=1e-7).predict(conditions, parameters)
    for part in loose.status:
        assert np.array_equal(loose.status[part], tight.status[part])
    for name in ("engagement_time_s", "release_time_90_s"):
        ok = loose.status_of(name) == Status.ok
        assert np.abs(loose.values[name][ok] / tight.values[name][ok] - 1).max() < 3e-3


def test_predictions_are_smooth_in_the_parameters():
    """What is differentiated numerically must not carry the step control's noise."""
    model, conditions, parameters = draws(60, seed=5)
    for name in ("roughness_sd", "contact_stiffness", "film_kinetic"):
        centre = parameters.get(name, np.full((1, 60), model.parameters[name].default))
        slopes = []
        for step in (1e-3, 1e-4):
            moved = [model.predict(conditions, parameters | {name: centre * (1 + s * step)}) for s in (-1, 1)]
            slopes.append({n: (moved[1].values[n] - moved[0].values[n]) / (2 * step) for n in TIMES[:3]})
        for observable in TIMES[:3]:
            rough, fine = (slope[observable][0] for slope in slopes)
            ok = np.isfinite(rough) & np.isfinite(fine)
            assert ok.sum() > 30
            scale = np.median(np.abs(fine[ok]))
            assert np.mean(np.abs(rough - fine)[ok] < 0.02 * scale + 0.02 * np.abs(fine[ok])) > 0.97


def test_polarisation_is_continuous_at_switch_off(model, runs):
    """No delay, no jump: with a slow drive the release tends to the instant of switch-off's own state."""
    from eaclutch.physics.kernels.drive import electroadhesion, fields_at
    from eaclutch.physics.kernels.forces import driven_field, field_force

    for effects, extra in (
        (BASE, {}),
        ((*BASE, "trapped_charge"), {"trapped_charge.residual_fraction": 0.5}),
    ):
        row = ClutchModel(model.bench, effects).rows(runs(frequency=0.1), extra)[0][0, 0]
        driven = field_force(row, driven_field(row), 5e-6, tables())
        later = [
            electroadhesion(row, fields_at(row, t, RELEASING, tables()), 5e-6, tables()) for t in (0.0, 1e-13)
        ]
        assert later == pytest.approx([driven, driven], rel=2e-3 if extra else 1e-3)
