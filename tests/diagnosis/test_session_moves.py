"""What sessions differ by in one piece is no cause."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.conclude import far_apart
from eaclutch.diagnosis.session_moves import session_moves, sessions_apart, with_sessions
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study

STIFFNESS = 5.4e14
TERMS = [
    {"sd": 0.05, "parameters": ["contact_stiffness"]},
    {"sd": 0.1, "parameters": ["film_static", "film_kinetic"]},
    {"sd": 0.1, "parameters": ["of_another_model"]},
]


@pytest.fixture(scope="module")
def study():
    return Study(inputs(), load_thresholds())


def test_moves_are_what_the_model_says_of_one_sd(study):
    forward, n = study.forward(()), study.data.run_entries
    moves = session_moves(forward, study.first_fit, TERMS)
    assert np.all(moves[:, n:] == 0.0) and np.all(moves[2] == 0.0)
    stiffer = study.first_fit | {"contact_stiffness": study.first_fit["contact_stiffness"] * np.exp(0.05)}
    both = [
        forward.representative.predict_named({k: np.array([v]) for k, v in at.items()}, 1)[0, :n]
        for at in (study.first_fit, stiffer)
    ]
    moved = both[1] - both[0]
    assert np.any(np.abs(moved) > 1e-3)
    steady = np.abs(moves[0, :n]) > 1e-4
    assert np.median(np.abs(moves[0, :n] - moved)[steady] / np.abs(moved)[steady]) < 0.2
    capacity = study.data.channel[:n] == "shear_capacity_n"
    assert np.all(moves[1, :n][capacity] > 0.02)


def test_sessions_further_apart_than_usual_are_a_caveat():
    """A session that holds half as much again, many times the spread, without a name for it."""
    given = inputs()
    table = given.table.copy()
    last = table["session"] == table["session"].max()
    table.loc[last, "shear_capacity_n"] *= 1.5
    study = Study(replace(given, table=table), load_thresholds())
    shares = sessions_apart(study.data, study.base.mode.predicted)
    assert 0.2 < max(shares.values()) - min(shares.values()) < 0.6
    assert max(shares, key=lambda name: shares[name]) == table["session"].max()
    base = study.weigh(())
    assert base.multipliers[1] == 2.0
    for best in ((), ("unknown",)):
        (note,) = far_apart(study, [base], best)
        assert "2 times as far apart" in note and f"{table['session'].max()} +" in note
    # a drift says so itself, and what explains the gap may need less
    drift = replace(base, effects=("session_drift",))
    assert far_apart(study, [base, drift], drift.effects) == []
    named = replace(base, effects=("gas_slip",), multipliers=(1.0, 1.0))
    assert far_apart(study, [base, named], named.effects) == []
    one = replace(study.data, session=np.full(len(study.data), "a", dtype=object))
    assert sessions_apart(one, study.base.mode.predicted) == {}


def test_sessions_as_usual_are_none(study):
    base = study.weigh(())
    assert far_apart(study, [base], ()) == []
    # nor where something else than the force lies apart
    assert far_apart(study, [replace(base, multipliers=(1.0, 2.0))], ()) == []


def test_each_session_differs_in_its_own_way(study):
    sessions = np.array(["a", "a", "b"])
    moves = np.array([[1.0, -2.0, 3.0]])
    plain = replace(study.kernels, session=np.zeros((3, 3)))
    found = with_sessions(plain, sessions, moves).session
    assert np.allclose(found, [[1.0, -2.0, 0.0], [-2.0, 4.0, 0.0], [0.0, 0.0, 9.0]])


def test_a_session_of_stiffer_contact_is_hardly_a_drift():
    """By a quarter, seven times the spread: observable by observable it gains a name, and less than half of that so."""
    given = replace(inputs(parameters={"contact_stiffness": STIFFNESS}), candidates=("session_drift",))
    stiffer = inputs(parameters={"contact_stiffness": 1.25 * STIFFNESS}).table
    second = given.table["session"] == given.table["session"].max()
    assert second.any() and not second.all()
    table = given.table.where(~second, stiffer)

    def gain(**changes):
        study = Study(replace(given, table=table), {**load_thresholds(), **changes})
        return study.weigh(("session_drift",)).log_evidence - study.weigh(()).log_evidence

    apart = gain(session_together=[])
    assert apart > 7.0 and gain() < 0.5 * apart
