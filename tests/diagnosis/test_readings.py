"""What a run's largest slip shows of friction that scatters from slip to slip."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from diagnosis.simulated import BENCH, inputs
from eaclutch.diagnosis.channels import CHANNELS
from eaclutch.diagnosis.readings import Readings
from eaclutch.diagnosis.result import summarise
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel
from eaclutch.rig.table import conditions_from_runs

CHANNEL = [channel for channel in CHANNELS if channel.name in ("shear_capacity_n", "slip_fraction")]


@pytest.fixture(scope="module")
def read():
    """``read(**peaks)``: capacity [N] and slip fraction of each run, (2, runs)."""
    model, conditions = ClutchModel(BENCH, BASE), conditions_from_runs(inputs().table, BENCH)
    readings = Readings((), np.full(len(conditions), -1), peaks=True)

    def predict(**peaks: float) -> np.ndarray:
        named = {"film_static": np.array([0.19])} | {name: np.array([value]) for name, value in peaks.items()}
        found = readings.predict(model, conditions, named, CHANNEL)[0]
        return np.stack([channel.backward(row) for channel, row in zip(CHANNEL, found, strict=True)])

    return predict


def test_friction_that_scatters_as_a_whole_lets_go_the_same_share(read):
    typical, largest = read(), read(largest_slip_excess=0.1, largest_slip_static_share=0.0)
    assert np.all(largest[0] > typical[0])
    np.testing.assert_allclose(largest[1], typical[1], rtol=1e-12)


def test_static_friction_that_scatters_by_itself_falls_deeper(read):
    """F_min = F_kin - rho (F_stat - F_kin) with F_kin as it was: top and bottom of both slips lie on that line."""
    typical = read()
    largest = read(largest_slip_excess=0.1, largest_slip_static_share=1.0)
    before = conditions_from_runs(inputs().table, BENCH).friction_before
    tops = typical[0] + before, largest[0] + before
    bottoms = tops[0] * (1 - typical[1]), tops[1] * (1 - largest[1])
    np.testing.assert_allclose((bottoms[0] - bottoms[1]) / (tops[1] - tops[0]), 0.8598927, rtol=1e-6)


def test_noise_on_the_largest_force_makes_no_slip_larger(read):
    np.testing.assert_allclose(read(largest_noise_excess=0.01)[1], read()[1], rtol=1e-12)


def test_a_zero_that_leaves_a_session_no_preload_is_left_behind(monkeypatch):
    """Runs that begin in contact read 45 mN short on the second day: no slope leads from no preload back to some."""
    given = inputs()
    table = given.table.copy()
    late = (table["session"] == table["session"].max()).to_numpy()
    whole = (table["shear_capacity_n"] + table["friction_before_n"]).to_numpy()
    table["flags"] = "no_zero"
    for name in ("friction_before_n", "switch_off_force_n", "final_force_n"):
        table.loc[late, name] = table.loc[late, name] - 0.045
    table["slip_fraction"] = table["slip_fraction"] * np.where(late, whole / (whole - 0.045), 1.0)
    table["preload_n"] = np.nan
    short = replace(given, table=table)
    # from the defaults alone: a lucky draw of all parameters may stand beyond the place where slopes end
    monkeypatch.setattr("eaclutch.diagnosis.starts.BASE_STARTS", 0)
    with monkeypatch.context() as without:
        without.setattr("eaclutch.diagnosis.fit.HOPS", 0)
        stuck = Study(short, load_thresholds()).base
    found = Study(short, load_thresholds()).base
    assert found.peak > stuck.peak + 2.0
    last = max(name for name in found.parameters if name.startswith("force_zero_"))
    assert found.parameters[last] < stuck.parameters[last] - 0.005


def test_a_fit_with_effects_predicts_what_is_left_out_with_its_own_zeros(monkeypatch):
    study = Study(inputs(), load_thresholds())
    seen = Mock(side_effect=summarise)
    monkeypatch.setattr("eaclutch.diagnosis.study.summarise", seen)
    study.weigh(())
    study.weigh(("trigger_latency",))
    (_, *_, base, _), (fitted, *_, own, _) = (call.args for call in seen.call_args_list)
    assert base == study.readings and set(own) == set(base)
    mode = dict(zip(fitted.mode.names, fitted.mode.u.tolist(), strict=True))
    assert own == {name: mode[name] for name in own} and own != base


def test_effects_are_fitted_at_the_zeros_that_the_model_by_itself_has(monkeypatch):
    """Each other zero of each session costs a fit: once, not for every effect."""
    study = Study(inputs(), load_thresholds())
    assert study.base.effects == ()
    tried = Mock(return_value=[])
    monkeypatch.setattr("eaclutch.diagnosis.fit.other_zeros", tried)
    assert study.fit(("trigger_latency",), afresh=(2.0, 1.0)).effects == ("trigger_latency",)
    tried.assert_not_called()
