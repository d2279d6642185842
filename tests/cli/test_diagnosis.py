"""What the diagnosis' commands refuse to be handed."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from diagnosis.simulated import inputs
from eaclutch.cli.diagnosis import read_weighed, refuse_others
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.files import write_json
from eaclutch.records import InputError


@pytest.mark.parametrize(
    "names",
    [("trapped_chrage",), ("air_gap",), ("gas_slip", "gas_slip"), ("gas_slip", "film_tension", "gap_tilt")],
    ids=" ".join,
)
def test_what_cannot_be_weighed_is_refused_by_name(names):
    study = SimpleNamespace(candidates=("gas_slip", "film_tension", "gap_tilt"), lookalikes=("wet_film",))
    refuse_others(study, ("gas_slip", "wet_film"))
    with pytest.raises(InputError, match=names[0]):
        refuse_others(study, names)


def test_the_same_effects_in_two_files_and_lookalikes_are_refused(tmp_path):
    study = Study(inputs(), load_thresholds(), seed=3)
    base = study.weigh(("trigger_latency",))
    for name, effects in (("a", base.effects), ("b", base.effects), ("c", ("wet_film",))):
        write_json(tmp_path / name, replace(base, effects=effects).document())
    assert [r.effects for r in read_weighed([tmp_path / "a"], study)] == [("trigger_latency",)]
    with pytest.raises(InputError, match=r"b: weighs what another file does"):
        read_weighed([tmp_path / "a", tmp_path / "b"], study)
    with pytest.raises(InputError, match=r"c: weighs a lookalike"):
        read_weighed([tmp_path / "c"], study)
