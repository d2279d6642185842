"""Comparators on fits whose answer is plain."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.blind.comparators import COMPARATORS, Fits, compare
from eaclutch.records import InputError

EFFECTS = ((), ("gap_tilt",), ("slow_drive",), ("gap_tilt", "slow_drive"))


def fits(gap: float, nameless_gain: float) -> Fits:
    """Forty cells of unit noise with ``gap`` in eight of them, which gap_tilt takes away; slow_drive does nothing."""
    noise = np.random.default_rng(5).standard_normal(40)
    shift = np.where(np.arange(40) < 8, gap, 0.0)
    errors = np.stack([noise + shift, noise, noise + shift, noise])
    density = -0.5 * (errors**2).reshape(4, 10, 4).sum(axis=2) - np.array([[0.0], [0.2], [0.2], [0.4]])
    return Fits(EFFECTS, errors, errors * 1.05, density, np.array([0.0, 1.0, 2.0, 3.0]), nameless_gain)


@pytest.mark.parametrize("name", ["aic", "bic", "largest_residual", "loo"])
def test_comparators_find_a_plain_cause(name: str) -> None:
    found = compare(name, fits(6.0, 20.0), "here")
    assert found["verdict"]["effects"] == ["gap_tilt"]
    assert sum(h["probability"] for h in found["hypotheses"]) == pytest.approx(1.0)
    assert found["closure"]["shrinkage"] > 0.9


@pytest.mark.parametrize("name", ["bic", "largest_residual", "nameless_gp"])
def test_comparators_see_no_cause_where_there_is_none(name: str) -> None:
    assert compare(name, fits(0.0, -5.0), "here")["verdict"]["effects"] == []


def test_the_nameless_term_knows_a_gap_and_no_name() -> None:
    assert compare("nameless_gp", fits(6.0, 20.0), "here")["verdict"]["effects"] == ["unknown"]


def test_alternatives_are_three_at_most() -> None:
    for name in COMPARATORS:
        assert len(compare(name, fits(1.0, 0.0), "here")["verdict"]["alternatives"]) <= 3


def test_an_unknown_comparator_is_refused() -> None:
    with pytest.raises(InputError, match="is not known"):
        compare("tea_leaves", fits(1.0, 0.0), "here")
