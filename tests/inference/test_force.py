"""The force stage: cells, response, the multiplier's forms, and how capacities move the other parameters."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from eaclutch.inference.cells import Cells, cell_likelihood
from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.left_out import folds, refit_draws
from eaclutch.inference.response import Response
from eaclutch.inference.stages.force import CapacityData, MultiplierLaw, force_problem
from eaclutch.physics.parameters import MULTIPLIER_VOLTAGE, base_parameters
from eaclutch.records import Bench, RunConditions

PARAMETERS = dict(HYPERPARAMETERS) | base_parameters(Bench("x"), "linear")


def conditions(voltage, session, condition):
    n = len(voltage)
    fixed = {name: np.full(n, value) for name, value in (
        ("frequency", 1000.0), ("width", 2e-3), ("thickness", 2e-3), ("friction_before", 0.2),
        ("switch_off_force", 1.0), ("drive_duration", 3.0), ("dwell", 0.0), ("run_order", 0.0),
    )}  # fmt: skip
    return RunConditions(
        tuple(f"r{i}" for i in range(n)), session, condition, ("brass",) * n, np.asarray(voltage), **fixed
    )


def made_campaign(rng, level=1.1, slope=-1e-3, gain=1.2, runs=60):
    """ln capacity = ln gain + 0.8 ln(lambda) + 2 ln(V/200) + scatter, gain uncertain by 10 %."""
    voltage = np.repeat([150.0, 200.0, 250.0, 300.0], runs // 4)
    session = tuple(f"s{i % 3}" for i in range(runs))
    setup = conditions(voltage, session, tuple(f"{v:g}" for v in voltage))

    def capacity(nuisances, multiplier):
        return nuisances["gain"][:, None] * multiplier**0.8 * (voltage[None, :] / 200) ** 2

    lam = level + slope * (voltage - MULTIPLIER_VOLTAGE)
    shift = 0.02 * rng.standard_normal(3)[[i % 3 for i in range(runs)]]
    value = gain * lam**0.8 * (voltage / 200) ** 2 * np.exp(shift + 0.03 * rng.standard_normal(runs))
    nuisances = {"gain": np.exp(0.1 * rng.standard_normal(300)), "idle": rng.standard_normal(300)}
    response = Response.tabulate(capacity, nuisances, {"gain": "1", "idle": "1"})
    return CapacityData(setup, value, 0.005 * value), response, voltage


@pytest.mark.parametrize("sessions", [3, 7])
def test_cells_are_the_dense_normal(sessions):
    rng = np.random.default_rng(0)
    cells = Cells.of([f"s{i % sessions}" for i in range(30)], [f"c{i // 6}" for i in range(30)])
    residual, variance = rng.standard_normal((4, 30)), rng.uniform(0.5, 2, (4, 30))
    factors = rng.standard_normal((4, 2, cells.count))[:, :, cells.cell]
    session, condition = rng.uniform(0.1, 1, 4), rng.uniform(0.1, 1, 4)
    value = cell_likelihood(residual, factors, variance, session, condition, cells)
    for i in range(4):
        dense = np.diag(variance[i]) + factors[i].T @ factors[i]
        dense += session[i] ** 2 * cells.same_session + condition[i] ** 2 * cells.same_condition
        assert value[i] == pytest.approx(multivariate_normal(np.zeros(30), dense).logpdf(residual[i]))


def test_response_interpolates_and_marks_where_there_is_no_capacity():
    rng = np.random.default_rng(1)
    nuisances = {"a": rng.uniform(0.8, 1.2, 100)}

    def capacity(values, multiplier):
        found = values["a"][:, None] * np.array([[1.0, 3.0]]) * multiplier**0.7
        found[:, 1] = np.where(multiplier > 4.0, np.nan, found[:, 1])  # the second run pulls in
        found[:50, 0] = np.where(multiplier < 0.2, np.nan, found[:50, 0])
        return found

    response = Response.tabulate(capacity, nuisances, {"a": "1"})
    at = np.array([[1.37, 1.37], [0.15, 8.0], [-1.0, 1e3]])
    mean, factors, share = response.at(at)
    assert mean[0] == pytest.approx(
        np.log([1.0, 3.0]) + 0.7 * np.log(1.37) + np.log(nuisances["a"]).mean(), abs=1e-4
    )
    spread = np.sqrt(np.sum(factors[0] ** 2, axis=0))
    assert spread == pytest.approx(np.log(nuisances["a"]).std(), rel=0.01)
    assert share[0] == pytest.approx(0.0) and share[1, 0] == pytest.approx(np.log(0.5))
    assert share[1, 1] == -np.inf and np.all(share[2] == -np.inf)


def test_recovers_multiplier_and_moves_the_others():
    rng = np.random.default_rng(2)
    data, response, _ = made_campaign(rng)
    problem = force_problem(data, response, "linear", PARAMETERS)
    assert len(problem.priors) <= 6
    drawn = refit_draws(problem, 1500, rng)
    slope = drawn["force_multiplier_slope"]
    assert abs(slope.mean() + 1e-3) < 3 * slope.std() < 3e-3
    # only gain x lambda^0.8 is measured: both move from their priors (1 +- 0.1 each), their product is sharp
    product = np.log(drawn["gain"]) + 0.8 * np.log(drawn["force_multiplier_level"])
    assert product.mean() == pytest.approx(np.log(1.2) + 0.8 * np.log(1.1), abs=0.05)
    assert product.std() < 0.5 * np.log(drawn["gain"]).std()
    assert drawn["gain"].mean() > 1.05
    assert drawn["idle"].std() == pytest.approx(1.0, rel=0.15)


def test_a_share_between_two_ends_moves_and_stays_between_them():
    """Every other run loses a share of 30 % of its capacity, nearly all of it or hardly any."""
    rng = np.random.default_rng(6)
    data, _, voltage = made_campaign(rng, level=1.0, slope=0.0, gain=1.0)
    lossy = (np.arange(len(voltage)) % 2)[None, :]
    share = {"share": rng.uniform(0.0, 1.0, 300)}

    def capacity(nuisances, multiplier):
        return (
            (1 - 0.3 * nuisances["share"][:, None] * lossy) * multiplier**0.8 * (voltage[None, :] / 200) ** 2
        )

    for truth in (0.95, 0.05):
        seen = replace(data, capacity=data.capacity * (1 - 0.3 * truth * lossy[0]))
        response = Response.tabulate(capacity, share, {"share": "1"}, {"share": (0.0, 1.0)})
        drawn = refit_draws(force_problem(seen, response, "constant", PARAMETERS), 800, rng)["share"]
        assert drawn.min() >= 0.0 and drawn.max() <= 1.0
        assert abs(drawn.mean() - truth) < 0.15
        scaled = response.scales.forward(response.values)
        np.testing.assert_allclose(response.scales.back(scaled), response.values, atol=1e-6)


def test_conditioning_is_exact_for_a_linear_gaussian_model():
    """With lambda fixed at 1 and known spreads the gain's posterior is a one-dimensional normal in closed form."""
    rng = np.random.default_rng(3)
    data, response, voltage = made_campaign(rng, level=1.0, slope=0.0)
    problem = force_problem(data, response, "none", PARAMETERS)
    theta = np.tile([0.02, 0.03, 0.04], (4000, 1))
    moved = np.log(problem.derived(theta, rng)["gain"])
    cells = Cells.of(data.conditions.session, data.conditions.condition)
    dense = np.diag(0.04**2 + (data.capacity_sd / data.capacity) ** 2)
    dense += 0.02**2 * cells.same_session + 0.03**2 * cells.same_condition
    prior = np.log(response.values[:, 0])
    ones = np.linalg.solve(dense, np.ones(len(voltage)))
    precision = ones.sum() + 1 / prior.var()
    mean = (
        ones @ (np.log(data.capacity) - 2 * np.log(voltage / 200)) + prior.mean() / prior.var()
    ) / precision
    assert moved.mean() == pytest.approx(mean, abs=0.004)
    assert moved.std() == pytest.approx(precision**-0.5, rel=0.06)


def test_a_large_campaign_is_thinned_evenly_and_says_so():
    rng = np.random.default_rng(4)
    data, response, _ = made_campaign(rng, level=1.0, slope=0.0)
    assert data.thinned(len(data.capacity)) is data
    found = data.thinned(15)
    kept = Counter(zip(found.conditions.session, found.conditions.condition, strict=True))
    assert len(found.capacity) == 15 and found.thinned_from == len(data.capacity)
    assert len(kept) == 12 and max(kept.values()) == 2
    note = force_problem(found, response.select(np.arange(15)), "none", PARAMETERS).notes
    assert any(f"15 of {len(data.capacity)} runs" in line for line in note)


@pytest.mark.parametrize(("sessions", "most"), [(31, 600), (60, 600), (300, 600)])
def test_thinning_keeps_every_condition_and_spreads_the_sessions(sessions, most):
    session = [f"s{i:03d}" for i in range(sessions) for _ in range(20)] + ["s000"]
    condition = [f"c{j:02d}" for _ in range(sessions) for j in range(20)] + ["rare"]
    runs = len(session)
    setup = conditions(np.full(runs, 200.0), tuple(session), tuple(condition))
    found = CapacityData(setup, np.ones(runs), 0.01 * np.ones(runs)).thinned(most).conditions
    assert len(found) == most
    by_condition = Counter(found.condition)
    assert by_condition["rare"] == 1
    assert len(by_condition) == 21 and min(n for c, n in by_condition.items() if c != "rare") >= 29
    assert len(set(found.session)) > 0.7 * sessions
    assert max(Counter(found.session).values()) - min(Counter(found.session).values()) <= 8


def test_forms_of_the_multiplier():
    voltage = np.array([150.0, 300.0, 150.0])
    for form, names, expected in (
        ("none", (), [1.0, 1.0, 1.0]),
        ("constant", ("force_multiplier_level",), [2.0, 2.0, 2.0]),
        ("linear", ("force_multiplier_level", "force_multiplier_slope"), [1.85, 2.3, 1.85]),
        ("per_voltage", ("force_multiplier_150v", "force_multiplier_300v"), [2.0, 0.003, 2.0]),
    ):
        law = MultiplierLaw.of(form, voltage, PARAMETERS)
        assert tuple(p.name for p in law.parameters) == names
        np.testing.assert_allclose(law(np.array([[2.0, 0.003]])[:, : len(names)])[0], expected)


def test_too_little_is_said():
    rng = np.random.default_rng(4)
    data, response, _ = made_campaign(rng)
    rows = np.flatnonzero((np.array(data.conditions.session) == "s0") & (data.conditions.voltage == 200))
    few = CapacityData(data.conditions.select(rows), data.capacity[rows], data.capacity_sd[rows])
    problem = force_problem(few, response.select(rows), "linear", PARAMETERS)
    text = "; ".join(problem.notes)
    assert "one session only" in text and "one voltage only" in text
    slope = refit_draws(problem, 800, rng)["force_multiplier_slope"]
    assert slope.std() == pytest.approx(1e-3, rel=0.1)  # its prior
    assert not force_problem(None, None, "linear", PARAMETERS).has_data


def test_folds_hold_every_label_once():
    parts = folds(["a", "b", "c", "a", "d", "e"], 3, np.random.default_rng(0))
    assert sorted(label for part in parts for label in part) == ["a", "b", "c", "d", "e"]
    assert len(parts) == 3 and len(folds(["a"], 5, np.random.default_rng(0))) == 1
