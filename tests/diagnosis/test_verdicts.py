"""From tables to diagnosis.json on campaigns that the library simulates itself: the plumbing, not the benchmark."""

import json
from dataclasses import replace
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest

from diagnosis.simulated import BENCH, CANDIDATES, CONDITIONS, inputs
from eaclutch.diagnosis.causes import own_parameters
from eaclutch.diagnosis.conclude import caveats, conclude, session_spread, stopped
from eaclutch.diagnosis.drift import RepeatDrift
from eaclutch.diagnosis.forward import UNPREDICTED
from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.diagnosis.next_experiment import _grid
from eaclutch.diagnosis.pairs import with_pairs
from eaclutch.diagnosis.readings import Readings
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.verdict import decide
from eaclutch.diagnosis.weigh import probabilities
from eaclutch.files import Document
from eaclutch.physics.effects import BASE
from eaclutch.records import CapacitanceReadings, InputError


def diagnose(given):
    study = Study(given, load_thresholds(), seed=3)
    results = [study.weigh(())] + [study.weigh((name,)) for name in study.candidates]
    read = [CandidateResult.read(json.loads(json.dumps(r.document()))) for r in results]
    return conclude(study, read)


@pytest.fixture(scope="module")
def compliant():
    return diagnose(inputs(("series_compliance",), {"series_compliance.compliance": 2.5e-5}))


@pytest.fixture(scope="module")
def plain():
    return diagnose(inputs())


@pytest.fixture(scope="module")
def schema(request):
    path = request.config.rootpath / "workflow" / "schemas" / "diagnosis.schema.json"
    return json.loads(path.read_text())


def test_documents_keep_the_closed_schema(compliant, plain, schema):
    for document in (compliant, plain):
        jsonschema.validate(json.loads(json.dumps(document)), schema)


def test_probabilities_add_up_and_causes_list_everybody(compliant):
    assert sum(h["probability"] for h in compliant["hypotheses"]) == pytest.approx(1.0, abs=1e-9)
    assert {c["effect"] for c in compliant["causes"]} == {*CANDIDATES, "unknown", "none"}


def test_a_compliant_train_is_named_and_its_size_found(compliant):
    assert compliant["verdict"]["effects"] == ["series_compliance"]
    cause = next(c for c in compliant["causes"] if c["effect"] == "series_compliance")
    found = cause["parameters"]["compliance"]
    assert abs(found["mean"] - 2.5e-5) < 4 * found["sd"]
    assert cause["delta_elpd"] > cause["delta_elpd_se"] > 0
    assert compliant["closure"]["shrinkage"] > 0.6
    assert {row["phase"] for row in compliant["where"]} & {"ramp", "release"}


def test_the_parameters_of_a_cause_are_those_of_the_most_probable_set_that_holds_it():
    """Beside a second missing effect what an effect is alone stands in for both."""
    soft, late = ("series_compliance",), ("series_compliance", "trigger_latency")
    results = [
        SimpleNamespace(effects=(), parameters={}),
        SimpleNamespace(effects=soft, parameters={"compliance": {"mean": 1.2e-4}}),
        SimpleNamespace(
            effects=late,
            parameters={
                "series_compliance.compliance": {"mean": 4e-5},
                "trigger_latency.delay": {"mean": 3e-4},
            },
        ),
    ]
    together = own_parameters("series_compliance", results, {(): 0.0, soft: 0.2, late: 0.8})
    assert together == {"compliance": {"mean": 4e-5}}
    alone = own_parameters("series_compliance", results, {(): 0.0, soft: 0.8, late: 0.2})
    assert alone == {"compliance": {"mean": 1.2e-4}}
    assert own_parameters("gas_slip", results, {(): 1.0}) == {}


def test_what_is_left_out_is_predicted_by_a_fit_without_it():
    """The right effect predicts conditions that its fit did not see nearly as well as those it saw, the base model
    does not, and without a name for it the nameless term takes up the same gap."""
    study = Study(
        inputs(("series_compliance",), {"series_compliance.compliance": 2.5e-5}), load_thresholds(), seed=3
    )
    found = study.weigh(("series_compliance",))
    count = study.data.run_entries
    within, out = np.array(found.errors)[:count], np.array(found.errors_left_out)[:count]
    sd = np.sqrt(study.repeat_variance[:count])
    assert np.median(np.abs(out / sd)) < 3.0 * np.median(np.abs(within / sd)) + 1.0
    assert not np.allclose(out, within)
    base = np.array(study.weigh(()).errors_left_out)[:count]
    assert np.mean((out / sd) ** 2) < 0.2 * np.mean((base / sd) ** 2)
    nameless, residual = study.nameless.discrepancy[:count], study.base.residual[:count]
    assert np.sum((residual - nameless) ** 2 / sd**2) < 0.3 * np.sum(residual**2 / sd**2)


def test_no_run_speaks_for_an_entry_that_does_not_average_it():
    given = inputs()
    table = given.table.copy()
    first = table.index[table["condition"] == table["condition"].iloc[0]][1:]
    table.loc[first, "release_time_90_s"] = np.nan  # all but one repeat are of no use there
    study = Study(replace(given, table=table), load_thresholds())
    few = study.forward(()).representative
    for i in range(study.data.run_entries):
        used = study.data.average[i].indices % len(study.conditions)
        assert few.rows[few.place[i]] in used


def test_a_run_that_was_moved_back_to_the_wrong_place_shows_no_release():
    """One of its times contradicts the other runs of its condition; one that is too uncertain to say so is as wrong."""
    given = inputs()
    table = given.table.copy()
    table["flags"] = ""
    wrong, right = table.index[[1, 2]]
    table.loc[[wrong, right], "flags"] = "force_realigned_from_release"
    table.loc[wrong, ["release_time_50_s", "release_time_90_s"]] += 3e-3
    table.loc[wrong, "release_time_50_s_sd"] = 1e-3
    study = Study(replace(given, table=table), load_thresholds())
    run = {
        name: study.conditions.run.index(table.loc[row, "run"])
        for name, row in (("wrong", wrong), ("right", right))
    }
    for channel, values in zip(study.data.channels, study.data.run_values, strict=True):
        if channel.block == "release":
            assert np.isnan(values[run["wrong"]]) and np.isfinite(values[run["right"]])
        if channel.block == "capacity":
            assert np.isfinite(values[run["wrong"]])


def test_a_fit_that_stopped_short_is_made_again_from_where_others_stand():
    study = Study(
        inputs(("series_compliance",), {"series_compliance.compliance": 2.5e-5}), load_thresholds(), seed=3
    )
    found = [study.weigh(effects) for effects in ((), ("series_compliance",), ("substrate_inertia",))]
    short = replace(found[1], log_evidence=found[1].log_evidence - 6.0)
    again = with_pairs(study, [found[0], short, found[2]], 1)
    assert [r.effects for r in again[:3]] == [r.effects for r in found]
    assert again[1].log_evidence > short.log_evidence + 5.0
    assert all("." in name for name in again[3].parameters), "a pair says whose each parameter is"


@pytest.mark.parametrize("seed", [9, 10, 11])
def test_no_gap_is_called_no_gap_whatever_the_noise(seed):
    assert diagnose(inputs(seed=seed))["verdict"]["effects"] == []


def test_no_gap_is_called_no_gap(plain):
    assert plain["verdict"]["effects"] == []
    total = plain["gap"]["total"]
    assert total["before"] < 2.0 * total["noise_floor"]


def test_the_same_inputs_give_the_same_bytes():
    given = inputs(seed=8, conditions=CONDITIONS[:4])
    first, second = (json.dumps(diagnose(given)) for _ in range(2))
    assert first == second


def test_fits_that_another_job_made_are_taken_as_they_are():
    given, thresholds = (
        inputs(("series_compliance",), {"series_compliance.compliance": 2.5e-5}),
        load_thresholds(),
    )
    first = Study(given, thresholds, seed=3)
    known = json.loads(json.dumps(first.fits))
    again = Study(given, thresholds, seed=3, known=known)
    np.testing.assert_array_equal(first.data.noise_sd, again.data.noise_sd)
    assert first.weigh(()).document() == again.weigh(()).document()
    candidate = ("series_compliance",)
    assert first.weigh(candidate).document() == again.weigh(candidate).document()
    for fit in ("first_fit", "base_fit"):
        other = json.loads(json.dumps(known))
        del other[fit].get("at", other[fit])["mass"]
        with pytest.raises(InputError, match=r"gap\.json.*run diagnosis-gap again"):
            assert Study(given, thresholds, seed=3, known=other).base
    with pytest.raises(InputError, match=r"gap\.json: lacks 'first_fit'"):
        Study(given, thresholds, seed=3, known=Document("gap.json", {}))


def test_one_condition_in_one_session_says_what_it_cannot_tell():
    document = diagnose(inputs(conditions=CONDITIONS[:1], days=1, repeats=4))
    assert "one condition only" in document["verdict"]["why"]
    assert "one session only" in document["verdict"]["why"]


def test_no_capacitance_and_no_repeats_are_named():
    given = inputs(repeats=1)
    bare = DiagnosisInputs(BENCH, given.table, None, (), None, BASE, CANDIDATES)
    why = diagnose(bare)["verdict"]["why"]
    assert "no capacitance" in why
    assert "no repeats" in why


def test_a_table_without_usable_runs_is_refused():
    given = inputs(conditions=CONDITIONS[:1], days=1)
    table = given.table.assign(usable=False)
    with pytest.raises(InputError, match="no usable run"):
        Study(DiagnosisInputs(BENCH, table, None, (), None, BASE), load_thresholds())


def test_what_an_effect_explains_between_sessions_is_no_noise():
    drift = {"session_drift.offset_2": 0.4, "session_drift.friction_share": 0.0}
    given = replace(inputs(("session_drift",), drift), candidates=("session_drift",))
    study = Study(given, load_thresholds(), seed=3)
    after = study.weigh(("session_drift",))
    assert session_spread(study, study.weigh(())) == study.session_spread > 2.0
    assert session_spread(study, after) <= 1.0


def test_no_experiment_asks_for_more_than_the_supply_has_given(plain):
    assert max(entry["voltage_v"] for entry in plain["next_experiment"]) <= 300.0
    low = [
        c | {"voltage_v": min(c["voltage_v"], 150), "frequency_hz": min(c["frequency_hz"], 30)}
        for c in CONDITIONS
    ]
    grid = _grid(Study(inputs(conditions=low), load_thresholds(), seed=3))
    assert np.unique(grid.voltage).tolist() == [100.0, 150.0]
    assert np.unique(grid.frequency).tolist() == [0.1, 1.0, 10.0, 30.0]


def test_parameters_of_a_candidate_that_the_model_has_are_reported_and_the_config_says_how_many_campaigns():
    given = inputs(("series_compliance",), {"series_compliance.compliance": 2.5e-5})
    study = Study(replace(given, effects=(*BASE, "series_compliance")), load_thresholds(), seed=3)
    document = conclude(study, [study.weigh(())], campaigns=20)
    assert document["absorbed"]["series_compliance.compliance"]["before"] == pytest.approx(2.5e-5, rel=0.2)
    p_values = [entry["p_value"] for entry in document["gap"]["by_observable"].values()]
    assert min(p_values) >= 1 / 21 and np.allclose(21 * np.array(p_values), np.round(21 * np.array(p_values)))


def test_capacitance_that_is_off_has_a_place_with_its_own_sign_and_chance():
    """Readings that lack 8 pF; and those of a strip 2.5 times as wide that lack a third of theirs: the other's tell."""
    given = inputs()
    near = given.readings
    lacking = replace(near, capacitance=near.capacitance - 8e-12)
    wide = CapacitanceReadings(
        np.tile(near.force, 2), np.concatenate([near.capacitance, 2.5 / 1.5 * near.capacitance]),
        np.concatenate([near.width, 2.5 * near.width]), near.trial * 2, near.source * 2,
    )  # fmt: skip
    found = []
    for readings in (lacking, wide):
        study = Study(replace(given, readings=readings), load_thresholds(), seed=3)
        results = [study.weigh(effects) for effects in ((), ("stray_capacitance",))]
        rows = conclude(study, results, 99)["where"]
        found.append(next(row for row in rows if row["observable"] == "capacitance_pf"))
    assert found[0]["direction"] == "-"
    assert found[1]["p_value"] < 0.05


def test_what_the_model_cannot_say_is_as_far_off_for_one_run_as_for_all(monkeypatch):
    """A strip that never lets go has no release: the same distance from the measured one either way."""
    study = Study(inputs(), load_thresholds(), seed=3)
    forward, said = study.forward(()), Readings.predict

    def stuck(*arguments):
        found = said(*arguments)
        found[:, [c.name == "release_time_90_s" for c in study.data.channels]] = np.nan
        return found

    monkeypatch.setattr(Readings, "predict", stuck)
    theta = np.array([p.default for p in forward.parameters])
    runs = slice(0, study.data.run_entries)
    release = study.data.channel[runs] == "release_time_90_s"
    for prediction in (forward.predict(theta), forward.representative.predict(theta)):
        np.testing.assert_allclose(
            prediction[0, runs][release], study.data.values[runs][release] + UNPREDICTED
        )


def test_a_fit_that_stopped_short_is_said():
    results = [
        SimpleNamespace(effects=(), converged=True),
        SimpleNamespace(effects=("gas_slip",), converged=False),
    ]
    assert stopped(results, ()) == []
    assert stopped(results, ("gas_slip",)) == ["the fit with gas slip stopped before it had converged"]


@pytest.mark.parametrize(
    ("smooth", "words"), [(2.0, "within what passes for scatter"), (20.0, "as if friction changed")]
)
def test_unknown_for_repeats_that_drift_is_said_so_unless_a_smooth_term_says_more(smooth, words):
    base = SimpleNamespace(
        effects=(), log_evidence=0.0, log_evidence_open=smooth, log_evidence_without=0.0,
        log_evidence_without_open=smooth, log_density=(), gap_left_out=1.0, adequate_p=0.5, multipliers=(1.0, 1.0),
        remainder_law=("friction", "run_order"), repeat_drift=8.0,
    )  # fmt: skip
    thresholds = load_thresholds()
    verdict = decide(probabilities([base], thresholds), [base], thresholds)
    assert verdict.effects == ("unknown",) and words in verdict.why


def test_a_drift_of_repeats_is_a_caveat_and_so_are_few_of_them():
    drift = RepeatDrift("shear_capacity_n", 0.72, 5e-5, 6.6, 0.09)
    study = SimpleNamespace(
        data=SimpleNamespace(bench=SimpleNamespace(notes=()), run_values=[np.arange(12.0) ** 2], odd=()), condensed=(),
        conditions=SimpleNamespace(condition=tuple("abcdef") * 2, session=("1",) * 6 + ("2",) * 6), swings=0,
        drift=drift, dof={"x": 5}, inputs=SimpleNamespace(effects=()),
    )  # fmt: skip
    assert [
        note for note in caveats(study) if "shear_capacity_n follow the run order" in note and "72%" in note
    ]
    study.drift = None
    assert caveats(study) == []
    study.dof = {"x": 2, "y": 0}
    assert [note for note in caveats(study) if "hardly any repeats (2 degrees of freedom" in note]
    study.dof = {"x": 0}
    assert [note for note in caveats(study) if "no repeats" in note and "across sessions" in note]
    study.data.run_values[0][6:] = np.nan  # one session: nothing else shows how runs scatter
    assert [note for note in caveats(study) if "no repeats" in note and "usually scatter" in note]
