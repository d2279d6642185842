"""How much a run counts that was measured to slip where the model says that it sticks."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study

RELEASE, HELD = "release_time_90_s", "switch_off_force_n"


def weight(study: Study, row: int) -> float:
    """Of a run in the entry of its release, over that of a repeat that counts as much as others."""
    place = [channel.name for channel in study.data.channels].index(RELEASE)
    average = study.data.average.tocsc()[:, place * len(study.conditions) + row]
    entry = study.data.average[int(average.indices[0])]
    return float(average.data[0] * entry.nnz)


@pytest.fixture(scope="module")
def case():
    """A campaign, the row of its most loaded run, and the least force at which that slips in the model."""
    given = inputs()
    study = Study(given, load_thresholds())
    row = int(np.argmax(study.data.preload))
    place = [channel.name for channel in study.data.channels].index(RELEASE)
    named = {name: np.array([value]) for name, value in study.first_fit.items()}

    def sticks(force: float) -> bool:
        held = study.conditions.switch_off_force.copy()
        held[row] = force
        data = replace(study.data, conditions=replace(study.conditions, switch_off_force=held))
        return bool(Forward(study.model(), data, (), study.priors).unpredicted(named)[0, place, row])

    low, high = 0.0, float(study.conditions.switch_off_force[row])
    assert sticks(low) and not sticks(high)
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if sticks(middle) else (low, middle)
    return given, study.conditions.run[row], high, study.fits


@pytest.mark.parametrize(
    ("share", "counts"), [(1.1, True), (0.99, False), (0.95, False), (0.92, False), (0.6, True)]
)
def test_a_run_on_the_verge_says_nothing_of_its_release(case, share, counts):
    """A little below the verge its friction may have been as much lower; far below, it contradicts the model. The first
    fit is that of the whole campaign: one with the run there may end elsewhere, and its verge with it."""
    given, run, verge, fits = case
    table = given.table.copy()
    table.loc[table["run"] == run, HELD] = share * verge
    study = Study(replace(given, table=table), load_thresholds(), known=fits)
    found = weight(study, study.conditions.run.index(run))
    assert found > 0.5 if counts else found < 0.1
