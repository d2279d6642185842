"""What counts of a hypothesis' evidence: a second effect is not named for what a single condition says."""

from types import SimpleNamespace

import pytest

from eaclutch.diagnosis.counted import counted_evidence
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.weigh import probabilities

THRESHOLDS = load_thresholds()
MOST = THRESHOLDS["one_condition"]
INERTIA, AGING = ("substrate_inertia",), ("contact_aging",)
BOTH = (*AGING, *INERTIA)


def weighed(effects, evidence, densities, tolerance=1.0):
    return SimpleNamespace(
        effects=effects, log_evidence=evidence, log_evidence_open=-1e3, log_evidence_without=0.0,
        log_evidence_without_open=10.0, log_density=densities, gap_left_out=1.0, adequate_p=1.0,
        multipliers=(tolerance, 1.0), repeat_drift=0.0,
    )  # fmt: skip


def counted(pair, singles):
    results = [weighed((), 0.0, (-30.0, -30.0, -30.0)), *singles, pair]
    return counted_evidence(results, THRESHOLDS)(pair), probabilities(results, THRESHOLDS)


SINGLES = [weighed(INERTIA, 100.0, (1.0, 2.0, -12.0)), weighed(AGING, 60.0, (-20.0, 2.0, 2.0))]


def test_what_one_condition_says_for_a_second_effect_counts_in_part():
    """All of its 13 nats over the better single are the last condition's."""
    found, weights = counted(weighed(BOTH, 113.0, (0.5, 1.5, 2.0)), SINGLES)
    assert found == pytest.approx(113.0 - 14.0 + MOST)
    assert weights[INERTIA] > 0.8 > 0.2 > weights[BOTH]


def test_what_several_conditions_say_for_it_does_in_full():
    found, weights = counted(weighed(BOTH, 113.0, (6.0, 6.5, -8.0)), SINGLES)
    assert found == pytest.approx(113.0)
    assert weights[BOTH] > weights[INERTIA]


def test_a_condition_that_speaks_against_it_is_not_held_for_it():
    found, _ = counted(weighed(BOTH, 90.0, (0.0, 1.0, -13.0)), SINGLES)
    assert found == 90.0


def test_a_single_effect_and_a_set_around_a_large_gap_count_in_full():
    """There it is the conditions left out that a set has to narrow, and evidences rest on where fits ended."""
    singles = [weighed(s.effects, s.log_evidence, s.log_density, 8.0) for s in SINGLES]
    assert counted(weighed(BOTH, 113.0, (0.5, 1.5, 2.0), 8.0), singles)[0] == pytest.approx(113.0)
    results = [weighed((), 0.0, (-30.0,) * 3), *SINGLES]
    assert [counted_evidence(results, THRESHOLDS)(single) for single in SINGLES] == [100.0, 60.0]


def test_a_base_effect_beside_a_set_counts_in_full_and_the_set_no_more_than_without():
    """A base effect that a model leaves out acts; what it stands beside was said by one condition all the same."""
    pair = weighed(BOTH, 113.0, (0.5, 1.5, 2.0))
    three = weighed((*BOTH, "film_weight"), 115.0, (0.5, 1.5, 4.0))
    results = [weighed((), 0.0, (-30.0,) * 3), *SINGLES, pair, three]
    found = counted_evidence(results, THRESHOLDS)
    assert found(three) - found(pair) == pytest.approx(2.0)
    assert found(pair) == pytest.approx(99.0 + MOST)
