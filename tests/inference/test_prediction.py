"""Predictions: scatter between repeats and sessions, calibration curves, left-out coverage on a made campaign."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.inference.cells import Cells
from eaclutch.inference.coverage import LEVELS, calibration, coverage_document, ranks
from eaclutch.inference.predict_campaign import _Campaign
from eaclutch.inference.repeatability import scatter
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench

NOTHING = np.zeros(1000)  # measurement error


def grid(conditions=12, sessions=3, repeats=4):
    labels = [(f"s{s}", f"c{c}") for c in range(conditions) for s in range(sessions) for _ in range(repeats)]
    session, condition = zip(*labels, strict=True)
    return Cells.of(session, condition), np.array([int(c[1:]) for c in condition])


def test_scatter_of_repeats_and_sessions():
    rng = np.random.default_rng(0)
    cells, condition = grid(conditions=40)
    shifts = 0.5 * rng.standard_normal(cells.count)
    values = condition + shifts[cells.cell] + 0.2 * rng.standard_normal(len(condition))
    found = scatter(values, NOTHING[: len(condition)], np.zeros(len(values)), cells)
    assert not found.relative and found.dof == len(values) - cells.count
    assert found.repeat == pytest.approx(0.2, rel=0.15)
    assert found.session == pytest.approx(0.5, rel=0.35)
    assert found.sd(np.ones(3)) == pytest.approx(np.hypot(found.repeat, found.session))


def test_relative_scatter_is_recognised():
    rng = np.random.default_rng(1)
    cells, condition = grid(conditions=40, sessions=1)
    level = np.exp(0.1 * condition)
    values = level * (1 + 0.05 * rng.standard_normal(len(level)))
    found = scatter(values, NOTHING[: len(condition)], np.zeros(len(values)), cells)
    assert found.relative and found.repeat == pytest.approx(0.05, rel=0.2) and found.session == 0.0


def test_preload_is_taken_out_of_the_scatter():
    rng = np.random.default_rng(2)
    cells, condition = grid(sessions=1, repeats=8)
    preload = rng.uniform(0, 1, len(condition))
    values = condition + 2.0 * preload + 0.1 * rng.standard_normal(len(condition))
    assert scatter(values, NOTHING[: len(condition)], preload, cells).repeat == pytest.approx(0.1, rel=0.2)
    assert scatter(values, NOTHING[: len(condition)], np.zeros_like(preload), cells).repeat > 0.4


def test_measurement_error_is_no_scatter_between_repeats():
    rng = np.random.default_rng(5)
    cells, condition = grid(conditions=40, sessions=1)
    values = condition + np.hypot(0.2, 0.1) * rng.standard_normal(len(condition))
    found = scatter(values, np.full(len(values), 0.1), np.zeros(len(values)), cells)
    assert found.repeat == pytest.approx(0.2, rel=0.2)
    assert scatter(values, np.full(len(values), 0.5), np.zeros(len(values)), cells).repeat == 0.0


def test_single_runs_have_no_scatter_of_their_own():
    cells, _ = grid(repeats=1, sessions=1)
    found = scatter(np.arange(12.0), NOTHING[:12], np.zeros(12), cells)
    assert found.dof == 0 and found.repeat == 0.0


def test_calibration_of_right_and_wrong_predictions():
    rng = np.random.default_rng(3)
    measured = rng.standard_normal(2000)
    curve = calibration(ranks(rng.standard_normal((400, 2000)), measured))
    np.testing.assert_allclose(curve["covered"], LEVELS, atol=0.03)
    assert np.all((curve["low"] < curve["covered"]) & (curve["covered"] < curve["high"]))
    narrow = calibration(ranks(0.5 * rng.standard_normal((400, 2000)), measured))
    assert narrow["covered"][8] < 0.65
    assert calibration(np.array([np.nan])) is None


def test_runs_without_a_number_do_not_count():
    replicated = np.random.default_rng(4).standard_normal((100, 3))
    replicated[:70, 1] = np.nan
    found = ranks(replicated, np.array([0.0, 0.0, np.nan]))
    assert np.isfinite(found).tolist() == [True, False, False]
    document = coverage_document({"in_sample": {"a": found}})
    assert document["in_sample"]["a"]["runs"] == 1


def test_a_fit_that_has_not_seen_a_session_keeps_its_draws_inside_their_bounds(monkeypatch):
    share = "drive_rise_fall.reversal_share"
    conditions = SimpleNamespace(run=("a", "b", "c"), session=("1", "1", "2"))
    inputs = SimpleNamespace(parameters=ClutchModel(Bench("x")).parameters, multiplier_form="linear")
    campaign = _Campaign(
        None, inputs, SimpleNamespace(conditions=conditions), {"other": np.ones(3)}, None, 1, 3
    )
    moved = {share: np.array([-0.2, 0.4, 1.7])}
    monkeypatch.setattr(_Campaign, "refit", lambda self, gone, rng: dict(moved))
    found = list(campaign.left_out("left_out_session", conditions.session, 2))
    assert len(found) == 2
    for fold in found:
        assert fold.joint[share].tolist() == [0.0, 0.4, 1.0]
        assert fold.joint["other"].tolist() == [1.0, 1.0, 1.0]
