"""Every withheld effect: exactly off at size 0, visible at size 1, and apart from the library."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from eaclutch.blind import candidates, strangers
from eaclutch.blind.bench_readings import capacitance_curve
from eaclutch.blind.case import clean_state
from eaclutch.blind.design import draw_design
from eaclutch.blind.plan import generator
from eaclutch.blind.skeleton import skeleton
from eaclutch.blind.world import Constants, Runs, draw_constants

LAWS = candidates.NAMED | strangers.UNNAMED
CONTRACT = {
    "trapped_charge", "edge_wrap", "permittivity_saturation", "electrostriction", "series_compliance",
    "substrate_inertia", "stray_capacitance", "trigger_latency", "slow_drive", "gap_tilt", "surface_adhesion",
    "contact_aging", "velocity_weakening", "gas_slip", "film_tension", "session_drift",
}  # fmt: skip


@pytest.fixture(scope="module")
def bench() -> tuple[Runs, Constants]:
    constants = draw_constants(generator("test", 3, "constants"))
    design = draw_design(generator("test", 3, "design"))
    runs = clean_state(design, constants, generator("test", 3, "scatter"))
    return every_third(runs), constants


def every_third(runs: Runs) -> Runs:
    """A third of the runs, so that the whole table of effects is quick; every session and width is among them."""
    knobs = {name: value[::3] for name, value in runs.knobs.items()}
    arrays = {f.name: getattr(runs, f.name)[::3] for f in fields(runs) if f.name != "knobs"}
    return Runs(**arrays, knobs=knobs)


def test_the_capacitance_fixture_is_off_by_half_a_pf_from_what_campaign_yaml_states() -> None:
    stray = [draw_constants(generator("test", seed, "constants")).stray_capacitance for seed in range(400)]
    assert np.std(stray) == pytest.approx(0.5e-12, rel=0.15)
    assert abs(np.mean(stray)) < 0.1e-12


@pytest.fixture(scope="module")
def plain(bench: tuple[Runs, Constants]) -> np.ndarray:
    return seen(*bench)


def seen(runs: Runs, c: Constants) -> np.ndarray:
    """What noise-free features and the capacitance bench show, and what only the reading shows."""
    curve = capacitance_curve(c, np.array([0.5, 2.0]), 2e-3) * 1e12
    return np.concatenate([skeleton(runs, c).ravel(), curve])


def test_all_names_of_the_contract_and_at_least_eight_strangers() -> None:
    assert set(candidates.NAMED) == CONTRACT
    assert len(strangers.UNNAMED) >= 8
    assert not set(strangers.UNNAMED) & CONTRACT


@pytest.mark.parametrize("name", LAWS)
def test_an_effect_is_off_at_size_zero_and_seen_at_size_one(
    name: str, bench: tuple[Runs, Constants], plain: np.ndarray
) -> None:
    off = seen(*LAWS[name](*bench, 0.0, generator("test", 3, name)))
    np.testing.assert_allclose(off, plain, rtol=1e-6, atol=1e-12)
    on = seen(*LAWS[name](*bench, 1.0, generator("test", 3, name)))
    change = np.abs(on - plain) / np.maximum(np.abs(plain), 1e-6)
    assert np.nanmax(change) > 0.01


def test_the_generator_imports_no_law_of_the_library() -> None:
    for path in Path(candidates.__file__).parent.glob("*.py"):
        text = path.read_text(encoding="utf-8")
        for room in ("physics", "simulation", "inference", "diagnosis"):
            assert f"eaclutch.{room}" not in text, path
