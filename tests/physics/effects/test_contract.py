"""What every effect found in the folder has to keep."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from eaclutch.physics.effect import Effect, Inputs
from eaclutch.physics.effects import BASE, CANDIDATES, EFFECTS, LOOKALIKES, NAMED, STAGES
from eaclutch.physics.sockets import Sockets

# The names of the contract; the folder may hold more.
PROMISED_BASE = {
    "air_gap", "surface_roughness", "squeeze_film", "dielectric_relaxation", "drive_rise_fall", "film_weight",
    "load_cell_dynamics",
}  # fmt: skip
PROMISED_CANDIDATES = {
    "trapped_charge", "edge_wrap", "permittivity_saturation", "electrostriction", "series_compliance",
    "substrate_inertia", "stray_capacitance", "trigger_latency", "slow_drive", "gap_tilt", "surface_adhesion",
    "contact_aging", "velocity_weakening", "gas_slip", "film_tension", "session_drift",
}  # fmt: skip

every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)


def _values(effect: Effect, choose) -> dict[str, np.ndarray]:
    return {p.name: np.asarray(choose(p), dtype=float) for p in effect.parameters}


def _same(a: Sockets, b: Sockets, shape: tuple[int, ...]) -> list[str]:
    """Names of the sockets that differ in any bit (kappa's not-a-number counts as kappa_static, 54.2)."""
    changed = []
    for field in dataclasses.fields(Sockets):
        pair = [np.broadcast_to(np.asarray(getattr(s, field.name), dtype=float), shape) for s in (a, b)]
        left, right = (np.where(np.isnan(values), 54.2, values) for values in pair)
        if not np.array_equal(left, right):
            changed.append(field.name)
    return changed


def test_the_folder_holds_what_the_contract_promises():
    assert set(BASE) >= PROMISED_BASE
    assert set(CANDIDATES) >= PROMISED_CANDIDATES
    assert sorted([*BASE, *CANDIDATES, *LOOKALIKES]) == sorted(EFFECTS)
    assert set(NAMED) == {*BASE, *CANDIDATES}, "a lookalike is never said"


@every_effect
def test_it_says_what_it_is(effect: Effect):
    assert effect.stage in STAGES
    assert effect.summary and effect.validity
    assert re.search(r"doi:10\.\d{4,}/\S+", effect.reference)
    names = [p.name for p in effect.parameters]
    assert len(set(names)) == len(names) >= 1
    assert any(p.neutral is not None for p in effect.parameters), "nothing switches it off"


@every_effect
def test_parameters_are_within_their_bounds(effect: Effect):
    for p in effect.parameters:
        low, high = p.bounds
        assert low < high and np.isfinite([low, high]).all()
        assert low <= p.default <= high
        assert p.unit
        if p.neutral is not None:
            assert low <= p.neutral <= high
        if effect.role != "base" and p.neutral is not None:
            assert p.default == p.neutral, "a candidate is off unless it is asked for"


@every_effect
def test_the_neutral_value_is_exactly_off(effect: Effect, inputs: Inputs):
    rng = np.random.default_rng(1)
    drawn = effect.draw(rng)
    off = _values(effect, lambda p: drawn[p.name] if p.neutral is None else p.neutral)
    unset = effect.apply(Sockets(), inputs, off)
    # say nothing while their amplitude is zero
    decoration = {
        "residual_decay_time",
        "weakening_speed",
        "adhesion_range",
        "adhesion_separating",
        "film_free_gap",
    }
    assert set(_same(unset, Sockets(), (4,))) <= decoration


@every_effect
def test_draws_are_plausible_and_switch_it_on(effect: Effect, inputs: Inputs):
    rng = np.random.default_rng(2)
    bounds = {p.name: p.bounds for p in effect.parameters}
    for _ in range(200):
        drawn = effect.draw(rng)
        assert set(drawn) == set(bounds)
        for name, value in drawn.items():
            assert isinstance(value, float), f"{name} is a {type(value).__name__}"
            assert bounds[name][0] <= value <= bounds[name][1]
    on = effect.apply(Sockets(), inputs, {name: np.asarray(value) for name, value in drawn.items()})
    assert _same(on, Sockets(), (4,))


@every_effect
def test_draws_lead_and_runs_come_last(effect: Effect, inputs: Inputs):
    """A column of draws gives, row by row, what each draw gives alone."""
    rng = np.random.default_rng(3)
    drawn = [effect.draw(rng) for _ in range(3)]
    together = effect.apply(Sockets(), inputs, {n: np.array([[d[n]] for d in drawn]) for n in drawn[0]})
    for row, one in enumerate(drawn):
        alone = effect.apply(Sockets(), inputs, {n: np.asarray(v) for n, v in one.items()})
        for field in dataclasses.fields(Sockets):
            a = np.broadcast_to(getattr(together, field.name), (3, 4))[row]
            b = np.broadcast_to(getattr(alone, field.name), (4,))
            np.testing.assert_array_equal(a, b, err_msg=field.name)


@every_effect
def test_every_amplitude_does_something(effect: Effect, inputs: Inputs):
    """Each parameter that has a neutral value changes a socket on its own, or a run is missing from this test."""
    sessions = dataclasses.replace(inputs, session_index=np.array([0, 1, 3, 5]))
    more = dataclasses.replace(inputs, session_index=np.array([2, 4, 6, 7]))
    rng = np.random.default_rng(4)
    drawn = effect.draw(rng)
    for p in effect.parameters:
        if p.neutral is None:
            continue
        only = _values(effect, lambda q, p=p: drawn[q.name] if q is p or q.neutral is None else q.neutral)
        changed = [_same(effect.apply(Sockets(), i, only), Sockets(), (4,)) for i in (sessions, more)]
        assert any(changed), p.name


@every_effect
def test_prior_reaches_from_nothing_to_the_plausible(effect: Effect):
    """A candidate's amplitude prior gives mass to zero (it may be absent) and to what ``draw`` calls plausible."""
    if effect.role == "base":
        return
    rng = np.random.default_rng(5)
    drawn = [effect.draw(rng) for _ in range(200)]
    for p in effect.parameters:
        if p.neutral is None:
            continue
        assert p.prior.distribution in {"halfnormal", "normal"}
        scale = p.prior.a if p.prior.distribution == "halfnormal" else p.prior.b
        typical = np.median([abs(d[p.name]) for d in drawn])
        assert 0.2 * scale < typical < 3.0 * scale, p.name
        assert scale < p.bounds[1]
