"""Each effect at values off its defaults, against numbers worked out by hand (a pocket calculator, not the code).

The four runs of conftest: 300 V 1 kHz 2 mm 0.2 N | 300 V DC | 150 V 10 Hz 4 mm 0.5 N, second session | no voltage.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from eaclutch.physics import laws
from eaclutch.physics.effects import EFFECTS
from eaclutch.physics.sockets import Sockets

CASES: dict[str, tuple[dict[str, float], dict[str, Any]]] = {
    # t_i = 1 / 100 s; t_h = 0.5 ms, 3 s (the whole drive), 50 ms, 0.5 ms: 0.4 times 1/21, 300/301, 5/6, 1/21
    "trapped_charge": (
        {"residual_fraction": 0.4, "corner_frequency": 50.0, "decay_time": 0.05},
        {"residual_fraction": [0.01904762, 0.39867110, 0.33333333, 0.01904762], "residual_decay_time": 0.05},
    ),
    # P + 0.5/0.327 x 0.5 N (P / 0.5 N)^(2/3) = 0.2 and 0.5 N: P = 0.0454465, 0.1529331 N; the sides are pressed by
    # 0.5 N (P / 0.5 N)^(2/3) = 0.1010780, 0.2269818 N; pulled by a half of it at 300 V, an eighth at 150 V;
    # 1.5 x 0.0505390 / 0.077, ..
    "edge_wrap": (
        {
            "friction_per_preload": 0.5,
            "damping_per_preload": 2.0,
            "squeeze_ratio": 1.5,
            "preload_exponent": 2 / 3,
            "pull_per_preload": 0.5,
            "width_exponent": 0.0,
        },
        {
            "side_friction": [0.05053901, 0.05053901, 0.11349088, 0.05053901],
            "side_friction_static": [0.06169697, 0.06169697, 0.13854731, 0.06169697],
            "side_damping": [0.20215603, 0.20215603, 0.45396353, 0.20215603],
            "side_pull": [0.05053901, 0.05053901, 0.02837273, 0.0],
            "damping_factor": [0.98452617, 0.98452617, 2.21086203, 0.98452617],
        },
    ),
    # 150 V over 24 um: 6.25 MV/m; 75 V: 3.125 MV/m
    "permittivity_saturation": (
        {"coefficient": 2e-14},
        {"saturation_ratio": [0.78125, 0.78125, 0.1953125, 0.0]},
    ),
    "electrostriction": (
        {"coefficient": 3e-15},
        {"thinning_ratio": [0.1171875, 0.1171875, 0.029296875, 0.0]},
    ),
    # 4 mm wide: half as much to the power 1/2
    "series_compliance": (
        {"compliance": 1e-5, "width_exponent": 0.5, "film_share": 0.2},
        {
            "series_compliance": [8e-6, 8e-6, 5.65685425e-6, 8e-6],
            "film_compliance": [2e-6, 2e-6, 1.41421356e-6, 2e-6],
        },
    ),
    "substrate_inertia": ({"participation": 0.7}, {"added_mass": [2.8e-3, 2.8e-3, 5.6e-3, 2.8e-3]}),
    "stray_capacitance": ({"capacitance": 5e-12}, {"stray_capacitance": 5e-12}),
    "trigger_latency": ({"delay": 2e-4}, {"drive_delay": 2e-4}),
    # half as slow at reversals: half a wave of 0.5 ms loses tanh(x) / x of its mean square at 17.5 us, x = 14.28571
    "slow_drive": (
        {"resistance": 1e6, "voltage_exponent": 0.5, "reversal_ratio": 0.5},
        {
            "force_factor": [0.93, 0.9999930, 0.99901005, 0.99595855],
            "rise_time_constant": [35e-6, 35e-6, 49.4974747e-6, 2.02072594e-6],
            "fall_time_constant": [35e-6, 35e-6, 49.4974747e-6, 2.02072594e-6],
            "edge_straightness": [0.5, 0.5, 0.5, 0.5],
        },
    ),
    # sqrt(2^2 + 3^2) / sqrt(12) um and, 4 mm wide, sqrt(4^2 + 3^2) / sqrt(12) um
    "gap_tilt": (
        {"angle": 1e-3, "lift": 3e-6, "fixture_share": 0.3},
        {
            "gap_spread_sd": [1.04083300e-6, 1.04083300e-6, 1.44337567e-6, 1.04083300e-6],
            "fixture_gap_spread_sd": [3.12249900e-7, 3.12249900e-7, 4.33012702e-7, 3.12249900e-7],
        },
    ),
    # 11.1 N Phi(-2) / Phi(-0.8) = 11.1 N x 0.02275013 / 0.21185540
    "surface_adhesion": (
        {"pressure": 1e5, "range_ratio": 2.5, "fixture_share": 0.5, "separation_ratio": 2.0},
        {
            "adhesion_force": [1.1919756, 1.1919756, 2.3839512, 1.1919756],
            "fixture_adhesion_force": [0.5959878, 0.5959878, 1.1919756, 0.5959878],
            "adhesion_range": 2.5,
            "adhesion_separating": 2.0,
        },
    ),
    # a ramp of 1 N / (9.009 N/s) = 0.11100 s; rests of half of it plus 0.5 ms, 0 and 50 ms
    "contact_aging": (
        {"rate": 0.05, "onset_time": 0.1},
        {
            "static_factor_ramp": 1.03733442,
            "static_factor_release": [1.02223431, 1.02207380, 1.03601381, 1.02207380],
        },
    ),
    "velocity_weakening": (
        {"depth": 0.3, "speed": 0.05},
        {"weakening_depth": 0.3, "weakening_speed": 0.05},
    ),
    "gas_slip": ({"mean_free_path": 1e-6}, {"slip_length": 1e-6}),
    "film_tension": (
        {"stiffness": 2e6, "width_exponent": 0.5, "hardening": 3e10, "free_gap": 8e-6},
        {
            "film_spring": [1.11e5, 1.11e5, 1.5697771e5, 1.11e5],
            "film_hardening": 3e10,
            "film_free_gap": 8e-6,
        },
    ),
    # exp(0.75 * 0.2) on the force, exp(0.25 * 0.2) on friction, exp(1.5 * 0.25 * 0.2) more on static, in the second
    # session only
    "session_drift": (
        {"offset_2": 0.2, "offset_3": -0.9, "friction_share": 0.25, "static_excess": 1.5},
        {
            "force_factor": [1.0, 1.0, 1.16183424, 1.16183424],
            "friction_factor": [1.0, 1.0, 1.05127110, 1.05127110],
            "static_factor_release": [1.0, 1.0, 1.07788415, 1.07788415],
            "static_factor_ramp": [1.0, 1.0, 1.07788415, 1.07788415],
        },
    ),
    "reading_drift": (
        {"rate": 0.04, "voltage_exponent": 2.0},
        {"reading_drift": [0.04, 0.04, 0.01, 0.0]},
    ),
    # 0.5 ms, 3 s, 50 ms, 0.5 ms over 50 ms: 0.00995017, 1, 0.63212056, 0.00995017 of a fifth of the field
    "leaky_film": (
        {"drained": 0.2, "leak_time": 0.05},
        {"force_factor": [0.99602389, 0.64, 0.76313483, 0.99602389]},
    ),
    "readout_lag": ({"time_constant": 3e-4}, {"readout_time": 3e-4}),
    # 0.5 * (0.1, 1e-5, 1e-3, 0.1)^2 and, 4 mm wide, twice that to the power 1/2: 0.005, .., 7.1e-7; a quarter of it
    # soon: 1 / 1.00125^2, .., then (1.00125 / 1.005)^2, ..
    "supply_sag": (
        {"sag": 0.5, "frequency_exponent": 2.0, "width_exponent": 0.5, "late_share": 0.75},
        {
            "force_factor": [0.99750468, 1.0, 0.99999965, 0.99750468],
            "held_factor": [0.99255124, 1.0, 0.99999894, 0.99255124],
        },
    ),
    # 4 mm: half of it at a power of 1
    "falling_friction": (
        {"softening": 0.3, "power": 2.0, "width_exponent": 1.0},
        {"softening": [0.3, 0.3, 0.15, 0.3], "softening_power": 2.0},
    ),
    # 0.5 at 300 V, half of that at 150 V, and 0.5 / 300 at the 1 V that it takes for none
    "capillary_bridges": (
        {"pull": 0.5, "drain_time": 5e-3, "voltage_exponent": 1.0},
        {
            "force_factor": [1.5, 1.5, 1.25, 1.00166667],
            "residual_fraction": [0.57735027, 0.57735027, 0.44721360, 0.04079085],
            "residual_decay_time": 0.01,
        },
    ),
    # 50.0671535 V beyond 250 V at 300 V, 0.00045398 V at 150 V: 1 - 0.6 x 0.16689051, squared, ..
    "gap_breakdown": (
        {"lost": 0.6, "onset": 250.0},
        {"force_factor": [0.80975811, 0.80975811, 0.99999637, 1.0]},
    ),
    # 0.6 at 300 V, a quarter of that at 150 V, 0.6 / 300^2 at 1 V
    "remanence": (
        {"residual_fraction": 0.6, "decay_time": 0.02, "voltage_exponent": 2.0},
        {"residual_fraction": [0.6, 0.6, 0.15, 6.66666667e-6], "residual_decay_time": 0.02},
    ),
    "sluggish_contact": (
        {"lag": 2e-4, "share": 0.6, "load_exponent": 0.3},
        {"contact_lag": 2e-4, "contact_lag_share": 0.6, "contact_lag_power": 0.3},
    ),
    # 4 mm: 5/8 of it beyond 1.5 mm, of which 0.4; 2 mm: 1/4
    "lost_area": ({"share": 0.4, "sound_width": 1.5e-3}, {"force_factor": [0.9, 0.9, 0.75, 0.9]}),
    # 0.2 N: 0.4 to the power 1/2; 0.5 N: 1
    "wet_film": (
        {"gain": 6.0, "preload_exponent": 0.5},
        {"damping_factor": [3.7947332, 3.7947332, 6.0, 3.7947332]},
    ),
    # the first session, and the second
    "humid_session": (
        {"gain_1": 0.5, "gain_2": 7.0, "gain_3": 9.0},
        {"damping_factor": [0.5, 0.5, 7.0, 7.0]},
    ),
    "slow_stage": ({"lost": 0.25}, {"stage_speed_factor": 0.75}),
    # 4 mm: twice the width to the power 1/2
    "viscous_drag": (
        {"drag": 2.0, "width_exponent": 0.5},
        {"side_damping": [2.0, 2.0, 2.8284271, 2.0]},
    ),
    # t_10-90 / ln 9, half of it at half strength
    "drive_rise_fall": (
        {"strength": 0.5},
        {"rise_time_constant": 0.5 * 3.77749278e-6, "fall_time_constant": 0.5 * 2.36662198e-6},
    ),
    # real form: 4 + 50.2 (1 + s c) / (1 + 2 s c + s^2), s = (w tau)^0.562, c = cos(0.562 pi / 2)
    "dielectric_relaxation": (
        {"strength": 1.0},
        {"kappa_driven": [50.8352735, 54.1813288, 53.9510635, 50.8352735], "relaxing": 1.0},
    ),
    "air_gap": ({"strength": 0.25}, {"gap_in_force": 0.25}),
    "surface_roughness": ({"strength": 0.25}, {"roughness_in_force": 0.25}),
    "squeeze_film": ({"strength": 0.25}, {"damping_factor": 0.25}),
    "film_weight": ({"strength": 0.5}, {"film_weight": [2.30535e-5, 2.30535e-5, 4.6107e-5, 2.30535e-5]}),
    "load_cell_dynamics": ({"strength": 0.5}, {"load_cell_dynamic": 1.0}),
}


def test_a_larger_slip_overshoots_farther():
    """F_min = F_kin - rho (F_stat - F_kin): 1 N against 0.75 N at rho 0.8 ends at 0.55 N; 1.1 N at 0.47 N."""
    np.testing.assert_allclose(laws.larger_slip(0.45, 0.1, 0.8), (1.1 - 0.47) / 1.1, rtol=1e-12)
    np.testing.assert_allclose(laws.larger_slip(0.45, 0.0, 0.8), 0.45, rtol=1e-12)
    # k 18 018 N/m, m 1.1 g, b 0.43 kg/s: damping ratio 0.0482931
    np.testing.assert_allclose(laws.slip_overshoot(18018.0, 1.1e-3, 0.43), 0.8590778, rtol=1e-6)
    assert laws.slip_overshoot(1.0, 1.0, 5.0) == 0.0


def test_walls_carry_less_of_a_wide_pad_and_pull_as_the_film_is_charged(fill):
    """4 mm: c = 0.25 at q = 1: P + 0.25/0.327 x 0.5 N (P / 0.5 N)^(2/3) = 0.5 N: P = 0.2556040 N; half the
    permittivity at half of 300 V: (1/8)^(3/2) of the pull at m = 3."""
    values, _ = CASES["edge_wrap"]
    filled = fill(
        "edge_wrap",
        sockets=Sockets(kappa_driven=27.1),
        **values | {"width_exponent": 1.0, "voltage_exponent": 3.0},
    )
    assert np.ravel(filled.side_friction)[2] == pytest.approx(0.07991748, rel=2e-6)
    assert np.ravel(filled.side_pull)[2] == pytest.approx(0.007063774, rel=2e-6)


def test_every_effect_has_worked_numbers():
    assert set(CASES) == set(EFFECTS)


@pytest.mark.parametrize("name", CASES)
def test_law(name: str, fill):
    values, expected = CASES[name]
    filled = fill(name, **values)
    for socket, numbers in expected.items():
        found = np.broadcast_to(getattr(filled, socket), (4,))
        np.testing.assert_allclose(found, np.broadcast_to(numbers, (4,)), rtol=2e-6, err_msg=socket)


@pytest.mark.parametrize("name", ["squeeze_film", "wet_film", "humid_session"])
def test_what_resists_parting_adds_to_what_is_there(name, fill):
    """Or one of them would switch another off, by the order of their names."""
    values, expected = CASES[name]
    filled = fill(name, sockets=Sockets(damping_factor=2.0), **values)
    np.testing.assert_allclose(
        np.broadcast_to(filled.damping_factor, (4,)), 2.0 + np.asarray(expected["damping_factor"])
    )


def test_dipoles_keep_up_with_a_slow_edge(fill, inputs):
    # a lag of three relaxation times leaves a quarter of the relaxation after a step
    tau = float(inputs.parameters["relaxation_time"])
    filled = fill("dielectric_relaxation", sockets=Sockets(field_lag=3.0 * tau), strength=1.0)
    np.testing.assert_allclose(filled.relaxing, 0.25)


def test_contact_ages_with_the_load_that_the_stage_takes_up(fill, inputs):
    # 2 N take 0.22200 s; a force that is not known counts as 1 N, none at all as 0.02 N
    forces = np.array([2.0, np.nan, -0.1, 1.0])
    object.__setattr__(inputs.conditions, "switch_off_force", forces)
    filled = fill("contact_aging", rate=0.05, onset_time=0.1)
    np.testing.assert_allclose(
        filled.static_factor_ramp, [1.05846910, 1.03733442, 1.00109786, 1.03733442], rtol=1e-7
    )


def test_contact_aging_may_be_a_power_of_time_or_end(fill):
    """The ramp lasts 0.111000 s: 2 (sqrt(2.11) - 1) at n = 1/2; at n = -1 never more than the rate."""
    factors = {
        n: np.asarray(
            fill("contact_aging", rate=0.05, onset_time=0.1, exponent=n).static_factor_ramp
        ).ravel()[0]
        for n in (0.5, 1e-9, 0.0, -1.0)
    }
    assert factors[0.5] == pytest.approx(1.0 + 0.05 * 2.0 * (np.sqrt(2.11) - 1.0), rel=1e-5)
    assert factors[1e-9] == pytest.approx(factors[0.0], rel=1e-9)
    assert factors[-1.0] == pytest.approx(1.0 + 0.05 * 1.11 / 2.11, rel=1e-5)
    late = fill("contact_aging", rate=0.05, onset_time=1e-6, exponent=-1.0)
    assert np.all(np.asarray(late.static_factor_ramp) < 1.05)


def test_spreads_of_the_gap_join_by_their_variances(fill):
    filled = fill("gap_tilt", sockets=Sockets(gap_spread_sd=3e-6), angle=4e-6 * np.sqrt(12.0) / 2e-3)
    np.testing.assert_allclose(np.asarray(filled.gap_spread_sd)[0], 5e-6)


def test_electrostriction_stops_at_half_the_film(fill, inputs):
    high = np.array([3000.0, 300.0, 150.0, 0.0])
    object.__setattr__(inputs.conditions, "voltage", high)
    filled = fill("electrostriction", coefficient=1.2e-14)
    np.testing.assert_allclose(filled.thinning_ratio, [0.5, 0.46875, 0.1171875, 0.0])


def test_a_parallel_plate_has_the_whole_voltage_over_the_film(fill, inputs):
    from dataclasses import replace

    plate = replace(inputs, bench=replace(inputs.bench, pad=replace(inputs.bench.pad, type="parallel_plate")))
    np.testing.assert_allclose(plate.film_field, 2.0 * np.asarray(inputs.film_field))


@pytest.mark.parametrize("exponent", [0.4, 1.0, 2.5])
def test_side_friction_is_part_of_the_friction_that_tells_the_preload(fill, inputs, exponent):
    """What presses the strip and what the walls rub add up to the friction before the voltage, at any power."""
    filled = fill("edge_wrap", friction_per_preload=3.0, preload_exponent=exponent, width_exponent=0.0)
    foot = np.asarray(filled.side_friction)[:3] / 3.0
    preload = 0.5 * (foot / 0.5) ** (1.0 / exponent)
    np.testing.assert_allclose(
        0.327 * preload + 3.0 * foot, 0.327 * np.asarray(inputs.preload)[:3], rtol=1e-6
    )


def test_where_all_friction_differs_the_walls_still_add_up_to_the_friction_before(inputs):
    """A session that rubs 1.3 times as much: 1.3 mu P, the weights' friction and the walls' are what was measured."""
    sockets = Sockets(friction_factor=1.3)
    values = {p.name: p.default for p in EFFECTS["edge_wrap"].parameters}
    values |= {"friction_per_preload": 3.0, "preload_exponent": 1.5, "width_exponent": 0.0}
    foot = np.asarray(EFFECTS["edge_wrap"].apply(sockets, inputs, values).side_friction)[:3] / 3.0
    preload = 0.5 * (foot / 0.5) ** (1.0 / 1.5)
    weights = inputs.conditions.friction_before[:3] - 0.327 * np.asarray(inputs.preload)[:3]
    np.testing.assert_allclose(
        1.3 * (0.327 * preload + weights) + 3.0 * foot, inputs.conditions.friction_before[:3], rtol=1e-6
    )


def test_sessions_beyond_the_last_offset_share_it(fill, inputs):
    object.__setattr__(inputs, "session_index", np.array([0, 6, 7, 12]))
    filled = fill("session_drift", offset_1=-0.2, offset_7=0.1, offset_8=0.3, friction_share=0.0)
    np.testing.assert_allclose(filled.force_factor, np.exp([-0.2, 0.1, 0.3, 0.3]))
