"""Repeats that follow the run order are no scatter."""

from types import SimpleNamespace

import numpy as np
import pytest

from eaclutch.diagnosis import drift
from eaclutch.diagnosis.drift import repeat_drift

THRESHOLDS = {"repeat_drift": 2.0, "session_sd": {"capacity": 0.03}, "caveats": {"order_p_value": 0.01}}
RUNS = 60


def campaign(
    drift, *, seed=0, repeats_apart=True, channels=1, preload_slope=0.0, preload_drift=0.0, tails=False
):
    """60 runs, 3 sessions of 20, ten conditions twice a session; ``drift``: log per run of the order."""
    rng = np.random.default_rng(seed)
    order = np.tile(np.arange(20), 3)
    session = np.repeat(["a", "b", "c"], 20)
    condition = np.tile(np.arange(10), 6) if repeats_apart else np.tile(np.repeat(np.arange(10), 2), 3)
    friction = 0.2 + 0.02 * rng.standard_normal(RUNS) + preload_drift * order
    noise = rng.standard_t(1.5, (channels, RUNS)) if tails else rng.standard_normal((channels, RUNS))
    values = noise * 0.02 + condition
    values[-1] += drift * order + preload_slope * friction
    names = np.array([f"c{i}_p0.25-0.75N" for i in condition])
    return SimpleNamespace(
        run_values=values, groups=np.unique(np.char.add(names, session), return_inverse=True)[1],
        conditions=SimpleNamespace(condition=names, session=session, run_order=order, friction_before=friction),
        preload=np.full(RUNS, 0.5),
        channels=[SimpleNamespace(name=f"x{i}", block="capacity") for i in range(channels)],
    )  # fmt: skip


def found(**kwargs):
    return repeat_drift(campaign(**kwargs), THRESHOLDS, np.random.default_rng(1))


def test_orders_drawn_at_a_time_fit_into_memory_however_many_runs_there_are(monkeypatch):
    plain = found(drift=0.015)
    monkeypatch.setattr(drift, "PLACES", 10 * RUNS)
    few = found(drift=0.015)
    assert few.channel == plain.channel and few.p_value > plain.p_value
    assert few.p_value == pytest.approx(1.0 / (10 * drift.BATCHES + 1.0))


def test_a_drift_between_repeats_is_found_and_told():
    drift = found(drift=0.015, channels=3)
    assert drift is not None and drift.channel == "x2"
    assert drift.share > 0.9 and drift.p_value < 1e-5 and drift.evidence > 8.0
    assert drift.size == pytest.approx(0.015 * np.std(np.arange(20)), rel=0.1)


def test_scatter_is_none_however_far_its_tails_reach():
    """Of 100 campaigns of 5 channels, each with runs far off, chance puts one at most at p <= 0.01 on the average."""
    any_size = THRESHOLDS | {"repeat_drift": 0.0}
    seen = [
        repeat_drift(
            campaign(0.0, seed=seed, channels=5, tails=True),
            any_size,
            np.random.default_rng(1),
        )
        for seed in range(100)
    ]
    assert sum(drift is not None for drift in seen) <= 4
    assert max((drift.evidence for drift in seen if drift), default=0.0) < 4.0


def test_one_as_small_as_sessions_may_differ_by_does_not_count():
    """0.008 a run, a root mean square of 0.046: clear above the scatter, less than 2 times 0.03."""
    assert found(drift=0.008) is None
    assert (
        repeat_drift(campaign(0.008), THRESHOLDS | {"repeat_drift": 1.0}, np.random.default_rng(1))
        is not None
    )


def test_repeats_side_by_side_say_too_little():
    drift = found(drift=0.015, repeats_apart=False)
    assert drift is None or drift.evidence < 3.0


def test_what_follows_the_preload_is_no_drift():
    """Friction that climbs by 0.005 N a run, and a capacity that follows it by 3 a newton: as is found above."""
    assert found(drift=0.0, preload_slope=3.0, preload_drift=0.005) is None


def test_without_repeats_there_is_nothing_to_look_at():
    data = campaign(0.02)
    data.groups = np.arange(RUNS)
    assert repeat_drift(data, THRESHOLDS, np.random.default_rng(1)) is None
    data = campaign(0.02)
    data.run_values[:] = np.nan
    assert repeat_drift(data, THRESHOLDS, np.random.default_rng(1)) is None
