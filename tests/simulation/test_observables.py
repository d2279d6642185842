"""The table without logs agrees with the physics it is made of, and with itself."""

from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest

from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, InputError
from eaclutch.rig.table import conditions_from_runs
from eaclutch.simulation.campaign import conditions_of
from eaclutch.simulation.noise import QUIET, BenchNoise
from eaclutch.simulation.observables import EDGE_SD, MEASUREMENT_SD, observe, simulate_table
from eaclutch.simulation.plan import Plan, PlannedRun


@pytest.fixture
def alike(plan: Plan) -> Plan:
    """Two hundred repeats of one condition."""
    first = plan.runs[0]
    runs = tuple(replace(first, stamp=first.stamp + timedelta(minutes=i)) for i in range(200))
    return replace(plan, runs=runs)


def _parts(plan: Plan, bench: Bench):
    model = ClutchModel(bench)
    values = {name: p.default for name, p in model.parameters.items()}
    return model, values, conditions_of(plan, bench, values)


def test_a_quiet_bench_shows_the_model_but_for_the_reading(alike: Plan, bench: Bench):
    model, values, conditions = _parts(alike, bench)
    observed, stated, truth = observe(model, conditions, values, QUIET, np.random.default_rng(1))
    expected = model.predict(conditions, values).values["shear_capacity_n"][0, 0]
    np.testing.assert_allclose(truth["shear_capacity_n"], expected, rtol=1e-9)
    for name in ("shear_capacity_n", "ramp_rate_n_s", "engagement_time_s"):
        pulls = (observed[name] - truth[name]) / stated[name]
        assert abs(pulls.mean()) < 0.25 and pulls.std() == pytest.approx(1.0, abs=0.15)


def test_times_from_one_edge_share_its_doubt(alike: Plan, bench: Bench):
    model, values, conditions = _parts(alike, bench)
    observed, _, truth = observe(model, conditions, values, QUIET, np.random.default_rng(2))
    errors = [observed[name] - truth[name] for name in ("release_time_10_s", "release_time_90_s")]
    assert np.corrcoef(*errors)[0, 1] > 0.7
    spread = np.hypot(EDGE_SD, MEASUREMENT_SD["release_time_90_s"])
    assert np.std(errors[1]) == pytest.approx(spread, rel=0.15)


def test_the_largest_of_many_scattered_slips_is_above_the_mean(alike: Plan, bench: Bench):
    """Slips of 3 % scatter: the largest of n lies above by 0.03 times the mean maximum of n normals, 1.9 for 22."""
    model, values, conditions = _parts(alike, bench)
    conditions = replace(conditions, drive_duration=conditions.drive_duration + 0.6)
    noise = replace(QUIET, capacity_scatter_slip=0.03)
    _, _, truth = observe(model, conditions, values, noise, np.random.default_rng(3))
    alone = model.predict(conditions, values).values["shear_capacity_n"][0, 0]
    total = conditions.friction_before[0]
    gain = np.log((truth["shear_capacity_n"].mean() + total) / (alone + total)) / 0.03
    assert 1.6 < gain < 2.2


def test_the_table_is_what_a_diagnosis_reads(plan: Plan, bench: Bench):
    made = simulate_table(plan, bench, BASE, {}, BenchNoise(), np.random.default_rng(4))
    conditions = conditions_from_runs(made.runs, bench)
    assert len(conditions) == len(plan.runs)
    assert set(conditions.session) == {"2025-03-03", "2025-03-04"}
    np.testing.assert_allclose(
        conditions.drive_duration, [0.2005, 0.25, 0.2, 0.2005], atol=4e-5
    )  # to a sample
    assert len(made.readings.force) == 25 and len(made.spectra) == 1 and len(made.bursts.frequency) == 10
    assert made.runs["usable"].all()


def test_the_same_seed_gives_the_same_table(plan: Plan, bench: Bench):
    a, b = (simulate_table(plan, bench, BASE, {}, BenchNoise(), np.random.default_rng(5)).runs for _ in "ab")
    assert a.equals(b)


def test_a_parameter_that_the_model_lacks_is_refused(plan: Plan, bench: Bench):
    with pytest.raises(InputError, match=r"parameters\.gas_slip\.thickness"):
        simulate_table(
            plan, bench, (*BASE, "gas_slip"), {"gas_slip.thickness": 1e-6}, QUIET, np.random.default_rng(6)
        )


def test_an_effect_moves_what_it_should(alike: Plan, bench: Bench):
    """A delay of 300 us is added to every release quantile."""
    late = {"trigger_latency.delay": 3e-4}
    tables = [
        simulate_table(alike, bench, effects, parameters, BenchNoise(), np.random.default_rng(6)).runs
        for effects, parameters in ((BASE, {}), ((*BASE, "trigger_latency"), late))
    ]
    for name in ("release_time_10_s", "release_time_50_s", "release_time_90_s"):
        shift = tables[1][name].mean() - tables[0][name].mean()
        assert shift == pytest.approx(3e-4, abs=1.5e-5)


def test_a_clutch_that_holds_shows_no_release(bench: Bench, plan: Plan):
    """Without voltage there is nothing to release: no times are made up, and the force stays where it was."""
    still = PlannedRun(datetime(2025, 3, 3, 15), 0.0, 1000.0, 2e-3, 0.1)
    made = simulate_table(replace(plan, runs=(still,)), bench, BASE, {}, QUIET, np.random.default_rng(7))
    row = made.runs.iloc[0]
    for name in ("release_time_10_s", "release_time_50_s", "release_time_90_s", "engagement_time_s"):
        assert np.isnan(row[name]) and np.isnan(row[f"{name}_sd"])
    assert row["final_force_n"] == pytest.approx(row["switch_off_force_n"], abs=0.02)
