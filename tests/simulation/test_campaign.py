"""A simulated campaign is a campaign: the rig's own readers take it, and it holds what was put in."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from eaclutch.config import load_bench
from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, InputError
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.capacitance import read_capacitance
from eaclutch.rig.events import find_events
from eaclutch.rig.load_cell import read_bursts
from eaclutch.rig.logs import read_log
from eaclutch.rig.spectra import read_spectra
from eaclutch.simulation.campaign import simulate_campaign
from eaclutch.simulation.noise import QUIET, BenchNoise
from eaclutch.simulation.plan import Plan


def _simulate(folder: Path, plan: Plan, bench: Bench, noise=None, effects=BASE, parameters=None, seed=5):
    rng = np.random.default_rng(seed)
    return simulate_campaign(folder, plan, bench, effects, parameters or {}, noise or BenchNoise(), rng)


def test_the_rigs_readers_take_it(tmp_path: Path, plan: Plan, bench: Bench):
    done = _simulate(tmp_path, plan, bench)
    campaign = open_campaign(tmp_path)
    assert [log.settings.run for log in campaign.logs] == sorted(done.conditions.run)
    assert len(read_capacitance(campaign).force) == 25
    (spectrum,) = read_spectra(campaign)
    assert spectrum.permittivity[0] == pytest.approx(52.0, rel=0.15)
    swings = read_bursts(campaign)
    omega = np.sqrt(18018.0 / 0.0011004)
    assert np.median(swings.frequency) == pytest.approx(omega / (2 * np.pi), rel=0.01)
    assert np.median(swings.damping_ratio) == pytest.approx(0.4274 / (2 * 0.0011004 * omega), rel=0.15)


def test_the_same_seed_gives_the_same_bytes(tmp_path: Path, plan: Plan, bench: Bench):
    for name in ("a", "b"):
        _simulate(tmp_path / name, plan, bench)
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    assert len(files) == 4 + 4
    for path in files:
        assert (tmp_path / "a" / path).read_bytes() == (tmp_path / "b" / path).read_bytes(), path


def test_a_quiet_run_logs_the_models_history(tmp_path: Path, plan: Plan, bench: Bench):
    """Without noise the log is the history, at the time stamps, from the logged edge on."""
    done = _simulate(tmp_path, plan, bench, QUIET)
    index = 1  # 10 Hz: the driver goes on for 50 ms after the stage has stopped
    recording = read_log(next((tmp_path / "tensile").glob(f"{done.conditions.run[index]}*")))
    events = find_events(recording)
    assert events.drive_duration == pytest.approx(done.conditions.drive_duration[index], abs=1e-4)
    assert events.dwell == pytest.approx(0.05, abs=1e-4)
    model = ClutchModel(bench)
    expected = model.history(done.conditions, index, done.parameters, recording.time - events.on)
    zero = np.median(recording.force[:300])
    late = (recording.time > events.on + 1e-3) & (recording.time < events.off - 1e-3)
    apart = np.abs(recording.force[late] - zero - expected[late])
    assert np.quantile(apart, 0.95) < 1e-3
    assert apart.max() < 0.03  # in a slip 39 us, half a sample of doubt about the edge, is up to 20 mN
    before = (recording.time > 0.5) & (recording.time < events.on)
    np.testing.assert_allclose(
        recording.force[before] - zero, done.conditions.friction_before[index], atol=1e-6
    )


def test_friction_before_gives_the_planned_preload_back(tmp_path: Path, plan: Plan, bench: Bench):
    from eaclutch.rig.preload import preload_of
    from eaclutch.simulation.campaign import conditions_of, settings_of

    values = {name: p.default for name, p in ClutchModel(bench).parameters.items()}
    conditions = conditions_of(plan, bench, values)
    for run, friction in zip(plan.runs, conditions.friction_before, strict=True):
        assert preload_of(friction, settings_of(run, plan.timing, bench), bench) == pytest.approx(run.preload)


def test_an_effect_shows_in_the_logs(tmp_path: Path, plan: Plan, bench: Bench):
    """A heavier load train rings slower: the quiet logs differ after release, not before the voltage."""
    base = _simulate(tmp_path / "base", plan, bench, QUIET)
    _simulate(tmp_path / "heavy", plan, bench, QUIET, (*BASE, "substrate_inertia"),
              {"substrate_inertia.participation": 1.0})  # fmt: skip
    run = base.conditions.run[0]
    a, b = (read_log(tmp_path / name / "tensile" / f"{run}.npy") for name in ("base", "heavy"))
    events = find_events(a)
    driven = (a.time > events.off) & (a.time < events.off + 2e-3)
    assert np.max(np.abs(a.force - b.force)[driven]) > 0.05
    np.testing.assert_array_equal(a.force[a.time < events.on], b.force[a.time < events.on])


def test_faults_go_where_they_are_asked_for(tmp_path: Path, plan: Plan, bench: Bench):
    done = _simulate(tmp_path, replace(plan, faults={"not_a_number": 1.0}), bench)
    assert set(map(tuple, done.faults.values())) == {("not_a_number",)}
    for path in (tmp_path / "tensile").iterdir():
        assert np.isnan(read_log(path).force).any()


def test_the_bench_is_written_as_it_is(tmp_path: Path, plan: Plan, bench: Bench):
    _simulate(tmp_path, plan, bench)
    found = load_bench(tmp_path)
    assert found.name == bench.name
    assert found.substrates["brass"].density == bench.substrates["brass"].density


def test_bad_requests_are_named(tmp_path: Path, plan: Plan, bench: Bench):
    with pytest.raises(InputError, match="stiffnes"):
        _simulate(tmp_path / "a", plan, bench, parameters={"stiffnes": 1.0})
    twice = replace(plan, runs=(plan.runs[0], plan.runs[0]))
    with pytest.raises(InputError, match="same name"):
        _simulate(tmp_path / "b", twice, bench)
    (tmp_path / "c" / "tensile").mkdir(parents=True)
    (tmp_path / "c" / "tensile" / "x").touch()
    with pytest.raises(InputError, match="holds recordings"):
        _simulate(tmp_path / "c", plan, bench)
