"""Another contact law than Greenwood-Williamson's: found beside the fit, said, and not taken for another stiffness."""

import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.conclude import conclude
from eaclutch.diagnosis.contact_law import other_contact_law
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.physics.model import ClutchModel

STIFFNESS, BEND = "contact_stiffness", "contact_law_bend"


@pytest.fixture(scope="module", params=[0.0, 0.5])
def found(request):
    study = Study(inputs((), {BEND: request.param}), load_thresholds())
    return study, study.weigh(()), request.param


def test_the_stiffness_is_right_whatever_the_law(found):
    study, result, bend = found
    known = study.constants(result)
    true = {BEND: bend, STIFFNESS: ClutchModel(study.inputs.bench).parameters[STIFFNESS].default}
    for name, value in true.items():
        assert abs(known[name]["mean"] - value) < 3.0 * known[name]["sd"]
    assert known[STIFFNESS]["sd"] < 0.3 * true[STIFFNESS] and known[BEND]["sd"] < 0.14
    # what is weighed knows no other law, and is further off where there is one
    assert BEND not in result.calibrated and known[STIFFNESS]["sd"] > result.calibrated[STIFFNESS]["sd"]
    off = [abs(entry[STIFFNESS]["mean"] - true[STIFFNESS]) for entry in (result.calibrated, known)]
    assert off[1] < off[0] or not bend


def test_it_is_said_where_it_matters(found):
    study, result, bend = found
    known = study.constants(result)
    said = other_contact_law(known, study.thresholds)
    assert [f"{known[BEND]['mean']:+.2f}" in note for note in said] == ([True] if bend else [])
    document = conclude(study, [result])
    assert document["absorbed"][STIFFNESS]["before"] == known[STIFFNESS]["mean"]
    assert document["verdict"]["effects"] == []
    assert ("contact law" in document["verdict"]["why"]) == bool(bend)
