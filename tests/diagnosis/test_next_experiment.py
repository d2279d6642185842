"""The runs that would tell most: of one bench, one session, and between hypotheses that differ."""

from dataclasses import replace

import numpy as np

from diagnosis.simulated import inputs
from eaclutch.diagnosis.next_experiment import _contenders, _grid, _separated, _variance, next_experiments
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.weigh import UNKNOWN


def test_where_a_tip_comes_to_rest_tells_no_experiment_from_another():
    study = Study(inputs(), load_thresholds(), seed=3)
    blocks = {channel.name: channel.block for channel in study.data.channels}
    for name, variance in zip(blocks, _variance(study), strict=True):
        assert variance >= study.thresholds["scatter"].get(blocks[name], 0.0) ** 2


def test_hypotheses_that_predict_the_same_are_still_two():
    assert _separated(np.zeros((3, 3)), np.full(3, 1 / 3)) == (0, 1)
    distance = np.zeros((3, 3))
    distance[0, 2] = distance[2, 0] = 1.0
    assert _separated(distance, np.full(3, 1 / 3)) == (0, 2)


def test_a_pair_whose_second_effect_does_nothing_is_no_rival_of_the_first():
    study = Study(
        inputs(("series_compliance",), {"series_compliance.compliance": 2.5e-5}), load_thresholds(), seed=3
    )
    plain, single = study.weigh(()), study.weigh(("series_compliance",))
    own = {f"series_compliance.{name}": entry for name, entry in single.parameters.items()}
    idle = {"trigger_latency.delay": {"mean": 0.0, "sd": 1e-6, "unit": "s"}}
    pair = replace(single, effects=("series_compliance", "trigger_latency"), parameters=own | idle)
    # an effect's parameter has its name in front, in a single's result, too, where it has not
    assert pair.named == single.named | {"trigger_latency.delay": 0.0}
    assert single.named.keys() == {*single.calibrated, *own}
    weights = {single.effects: 0.95, pair.effects: 0.04, plain.effects: 0.01}
    kept, said = _contenders(study, [plain, single, pair], weights, _grid(study), _variance(study))
    assert kept == [("series_compliance",), ()] and len(said) == 2


def test_unknown_predicts_what_its_best_lookalike_does():
    study = Study(
        inputs(("series_compliance",), {"series_compliance.compliance": 2.5e-5}), load_thresholds(), seed=3
    )
    named, slow = study.weigh(("series_compliance",)), study.weigh(("slow_stage",))
    plain = study.weigh(())
    weights = {named.effects: 0.6, UNKNOWN: 0.4, plain.effects: 0.0}
    ahead = replace(slow, log_evidence=named.log_evidence_without_open + 50.0)
    for result, contenders in ((ahead, [named.effects, UNKNOWN]), (slow, [named.effects, ()])):
        kept, said = _contenders(study, [plain, named, result], weights, _grid(study), _variance(study))
        assert kept == contenders and np.any(said[0] != said[1])
    assert "unknown" in next_experiments(study, [plain, named, ahead], weights)[0]["separates"]


def test_a_new_experiment_takes_strips_of_one_substrate():
    given = inputs()
    wide = given.table["width_mm"] == 5
    table = given.table.assign(
        substrate=np.where(wide, "steel", "brass"), width_mm=np.where(wide, 6, given.table["width_mm"])
    )
    grid = _grid(Study(replace(given, table=table), load_thresholds(), seed=3))
    assert set(grid.substrate) == {"brass"} and set(np.round(grid.width * 1e3, 6)) == {2.0, 5.0}


def test_a_new_experiment_is_of_one_session():
    study = Study(inputs(days=3), load_thresholds(), seed=3)
    grid = _grid(study)
    assert set(grid.session) == {"2025-03-03"}
    assert set(np.asarray(grid.session_number)) == {2}
