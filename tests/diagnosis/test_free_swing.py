"""What a measured free swing costs a model that has no such motion."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.conclude import caveats
from eaclutch.diagnosis.free_swing import charged, count_swings
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.weigh import probabilities
from eaclutch.physics.effects import BASE

STIFF = tuple(name for name in BASE if name != "load_cell_dynamics")


@pytest.fixture(scope="module")
def withheld():
    """A campaign whose runs swing, under a model that cannot."""
    given = inputs()
    table = given.table.assign(ringdown_frequency_hz=np.where(np.arange(len(given.table)) % 3, 640.0, np.nan))
    return replace(given, table=table, effects=STIFF, candidates=("load_cell_dynamics", "trigger_latency"))


def test_swings_are_counted_where_they_were_measured():
    table = pd.DataFrame({"ringdown_frequency_hz": ["310.2", "", None, "648"]})
    assert count_swings(table) == 2
    assert count_swings(pd.DataFrame({"run": ["a"]})) == 0


def test_what_cannot_swing_pays_and_what_can_does_not(withheld):
    thresholds = load_thresholds()
    study = Study(withheld, thresholds, seed=3)
    still = Study(
        replace(withheld, table=withheld.table.drop(columns="ringdown_frequency_hz")), thresholds, 3
    )
    most, nameless = thresholds["free_swing"]["most"], thresholds["free_swing"]["nameless"]
    for effects, cost in (((), most), (("trigger_latency",), most), (("load_cell_dynamics",), 0.0)):
        found, free = study.weigh(effects), still.weigh(effects)
        assert free.log_evidence - found.log_evidence == pytest.approx(cost)
        assert free.log_evidence_open - found.log_evidence_open == pytest.approx(cost)
        assert free.log_evidence_without - found.log_evidence_without == pytest.approx(most)
        assert free.log_evidence_without_open - found.log_evidence_without_open == pytest.approx(nameless)


def test_a_swing_calls_for_the_load_cell_by_name(withheld):
    study = Study(withheld, load_thresholds(), seed=3)
    results = [study.weigh(effects) for effects in ((), ("load_cell_dynamics",), ("trigger_latency",))]
    weights = probabilities(results, load_thresholds())
    assert weights[("load_cell_dynamics",)] > 0.5 > 100 * weights[("trigger_latency",)]
    assert any("swing freely" in note for note in caveats(study))


def test_a_model_that_swings_is_left_alone():
    result = Study(inputs(), load_thresholds(), seed=3).weigh(())
    assert charged(result, BASE, 50, load_thresholds()) is result
    assert charged(result, STIFF, 0, load_thresholds()) is result
