"""The confusion forecast: rows are distributions, no effect stays no effect, a clear effect is told."""

from datetime import date, datetime
from pathlib import Path

import numpy as np
import pytest

from eaclutch.diagnosis.forecast import SURE, Forecast
from eaclutch.diagnosis.modulated import changes
from eaclutch.diagnosis.planned import plan_of, planned_study
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.starts import scout_shifts
from eaclutch.physics.effects import BASE
from eaclutch.records import Bench, Campaign, LogFile, RunSettings, Substrate

BENCH = Bench("unit", substrates={"brass": Substrate(8338.5, 0.000726, 0.1, {2e-3: 2e-3})})


def campaign():
    """Four conditions, three repeats, on two days; the logs' names are all that is used."""
    logs = []
    for i in range(12):
        voltage, frequency = [(300.0, 1000.0), (250.0, 1000.0), (300.0, 10.0), (300.0, 10000.0)][i % 4]
        stamp = datetime.combine(date(2025, 3, 1 + i // 6), datetime.min.time()).replace(hour=12, minute=i)
        name = f"{stamp:%Y%m%d_%H_%M_%S}_bts_dx=1.5_v=0.5_Fpre=-1g_V={voltage:g}_f={frequency:g}_w=2_brass"
        settings = RunSettings(name, stamp, 1.5e-3, 0.5e-3, None, voltage, frequency, 2e-3, "brass")
        logs.append(LogFile(settings, Path(f"{name}.csv")))
    return Campaign(Path(), BENCH, tuple(logs), (), (), ())


@pytest.fixture(scope="module")
def forecast():
    chosen = {"diagnosis": {"candidates": ["series_compliance", "trigger_latency"]}}
    return Forecast(planned_study(campaign(), chosen, load_thresholds(), seed=5))


@pytest.fixture(scope="module")
def document(forecast):
    return forecast.document(np.random.default_rng(6))


def test_no_log_is_opened_to_plan():
    plan = plan_of(campaign())
    assert len(plan.runs) == 12
    assert {run.voltage for run in plan.runs} == {250.0, 300.0}


def test_a_forecast_has_data_of_the_model_that_it_fits():
    """The clamped rule makes 0.76 of the published one's force (physics.md, item 3)."""
    strong, weak = (
        planned_study(campaign(), {"model": {"roughness_rule": rule}}, load_thresholds(), seed=5).data
        for rule in ("published", "clamped")
    )
    capacities = [np.median(data.values[data.channel == "shear_capacity_n"]) for data in (strong, weak)]
    assert capacities[0] - capacities[1] > 0.2  # logarithms


def test_rows_are_distributions_over_all_verdicts(document):
    for row in document["matrix"].values():
        assert set(row) == {"series_compliance", "trigger_latency", "unknown", "none"}
        assert sum(row.values()) == pytest.approx(1.0)


def test_no_effect_is_rarely_named(document):
    assert document["matrix"]["none"]["none"] >= 0.95


def test_limits_are_where_the_right_verdict_becomes_likely(document):
    limit = document["limits"]["series_compliance"]
    assert "series_compliance" in document["identifiable"]
    reached = [float(size) for size, p in limit["probability_by_size"].items() if p >= SURE]
    assert limit["size"] == pytest.approx(min(reached), rel=1e-2)
    assert limit["parameters"]["compliance"] > 0


def test_a_law_that_is_on_or_off_is_told_and_not_taken_for_nothing():
    """A load cell that swings, in a model that lacks it: all releases move, by no parameter that has a slope."""
    effects = [name for name in BASE if name != "load_cell_dynamics"]
    chosen = {"model": {"effects": effects}, "diagnosis": {"candidates": ["load_cell_dynamics"]}}
    found = Forecast(planned_study(campaign(), chosen, load_thresholds(), seed=5))
    _, shifts = found.true_shifts("load_cell_dynamics", np.random.default_rng(1))
    assert np.ptp(shifts, axis=0).max() == 0.0 and np.abs(shifts).max() > 0.1
    assert (
        found.document(np.random.default_rng(6))["matrix"]["load_cell_dynamics"]["load_cell_dynamics"] > SURE
    )


def test_a_size_from_which_an_effect_is_told_is_not_one_beyond_which_it_is_confused(forecast, monkeypatch):
    index = forecast.names.index("trigger_latency")

    def told_in_the_middle(data):
        told = 5.0 < np.linalg.norm(data[0]) < 20.0
        return np.full(len(data), index if told else 0)

    monkeypatch.setattr(forecast, "verdicts", told_in_the_middle)
    monkeypatch.setattr(
        forecast, "simulate", lambda shift, replicas, rng, share: np.tile(shift, (replicas, 1))
    )
    shifts = np.zeros((1, len(forecast.study.data)))
    shifts[0, 0] = 20.0
    told = forecast._limit("trigger_latency", [{"delay": 1e-5}], shifts, np.random.default_rng(1))
    assert 1.0 in told["probability_by_size"].values() and told["size"] is None


def test_what_changes_with_frequency_is_unknown_to_the_forecast_too(forecast, monkeypatch):
    """A load cell that is softer or stiffer at high frequency, eight sd in all: nameless laws always see it, smooth
    terms over the channels do not."""
    study = forecast.study
    columns = next(
        columns
        for quantity, setting, columns in changes(study.base.mode, study.data, study.thresholds)
        if (quantity, setting) == ("stiffness", "drive frequency")
    )
    _, size, direction = np.linalg.svd(np.linalg.solve(forecast.root, columns), full_matrices=False)
    change = 8.0 / size[0] * columns @ direction[0]
    noise = np.random.default_rng(7).multivariate_normal(np.zeros(len(change)), forecast.covariance, 100)
    data, unknown = np.concatenate([noise + change, noise - change]), forecast.names.index("unknown")
    assert np.mean(forecast.verdicts(data) == unknown) > 0.9
    monkeypatch.setattr(forecast, "laws", [])
    assert np.mean(forecast.verdicts(data) == unknown) < 0.2


def test_what_a_lookalike_does_is_unknown_to_the_forecast_too(forecast, monkeypatch):
    """A slow readout delays the release as a late trigger does, the more the slower the force falls."""
    study = forecast.study
    shifts = scout_shifts(study.forward(("readout_lag",)), study.base)[0]
    distance = np.linalg.norm(forecast._whiten(shifts), axis=1)
    shift = shifts[np.argmax(distance)] * min(1.0, 12.0 / distance.max())
    data = forecast.simulate(shift, 200, np.random.default_rng(8), 0.2)
    unknown = forecast.names.index("unknown")
    assert np.mean(forecast.verdicts(data) == unknown) > 0.9
    priors = dict(zip(study.lookalikes, (prior for _, prior in forecast.lookalikes), strict=True))
    odds = study.thresholds["prior"]["odds"]["leaky_film"]
    assert np.exp(priors["leaky_film"] - priors["readout_lag"]) == pytest.approx(odds)
    monkeypatch.setattr(forecast, "lookalikes", [])
    assert np.mean(forecast.verdicts(data) == unknown) < 0.5


def test_the_odds_of_unknown_count_in_the_forecast_as_in_a_verdict(forecast, monkeypatch):
    """They take from names alone."""
    study = forecast.study
    shift = scout_shifts(study.forward(("trigger_latency",)), study.base)[0][0]
    shift *= 6.0 / np.linalg.norm(forecast._whiten(shift[None]))
    data = forecast.simulate(shift, 200, np.random.default_rng(9), 0.2)
    found = {}
    for odds in (1.0, 50.0):
        monkeypatch.setattr(study, "thresholds", study.thresholds | {"unknown_odds": odds})
        found[odds] = np.array(forecast.names)[forecast.verdicts(data)]
    changed = found[1.0] != found[50.0]
    assert np.any(changed)
    assert set(found[50.0][changed]) <= {"unknown", "none"}
    assert set(found[1.0][changed]) & {"trigger_latency", "series_compliance"}
    assert np.sum(found[50.0] == "unknown") > np.sum(found[1.0] == "unknown")
