"""Plans: what is captured, in which order, within which limits, and what a campaign still lacks."""

import shutil
from collections import Counter
from datetime import datetime

import numpy as np
import pytest

from eaclutch.files import write_json
from eaclutch.records import InputError
from eaclutch.rig.link.plan import make_plan, read_plan, slot_key
from eaclutch.rig.link.store import missing_slots
from eaclutch.rig.link.suggest import plan_from_suggestions
from eaclutch.rig.log_names import parse_log_name

FACTORS = {"voltage_v": [200, 300], "frequency_hz": [10, 1000], "width_mm": [2, 3]}


def document(**further):
    return {"name": "p", "repeats": 3, "factors": FACTORS, **further}


def test_every_condition_has_its_repeats_in_a_seeded_random_order():
    plan = make_plan(document(seed=4), "plan")
    assert set(Counter(map(slot_key, plan.slots)).values()) == {3}
    assert len(plan.slots) == 24
    assert make_plan(document(seed=4), "plan").slots == plan.slots
    assert make_plan(document(seed=5), "plan").slots != plan.slots
    listed = [slot.setting.voltage for slot in plan.slots]
    assert listed != sorted(listed)


def test_blocks_stay_together():
    plan = make_plan(document(block_by=["repeat", "width_mm"]), "plan")
    assert [slot.repeat for slot in plan.slots] == sorted(slot.repeat for slot in plan.slots)
    widths = [slot.setting.width for slot in plan.slots]
    changes_within = [int(np.count_nonzero(np.diff(widths[i : i + 8]))) for i in (0, 8, 16)]
    assert changes_within == [1, 1, 1]
    by_width = make_plan(document(block_by=["width_mm"]), "plan")
    assert np.count_nonzero(np.diff([slot.setting.width for slot in by_width.slots])) == 1


def test_listed_conditions_join_the_crossing_and_may_ask_for_more_repeats():
    more = {"voltage_v": 300, "frequency_hz": 10, "width_mm": 2, "repeats": 7}
    other = {"voltage_v": 250, "frequency_hz": 0.1, "width_mm": 2, "preload_g": 20}
    plan = make_plan(document(conditions=[more, other]), "plan")
    counts = Counter(map(slot_key, plan.slots))
    assert sorted(counts.values()) == [3] * 8 + [7]
    assert "dx=1.5_v=0.5_Fpre=20g_V=250_f=0.1_w=2_brass" in counts


@pytest.mark.parametrize(
    "change, key",
    [
        ({"factors": {"voltage_v": [400]}}, "voltage_v"),
        ({"factors": {"frequency_hz": [20000]}}, "frequency_hz"),
        ({"travel_mm": 6}, "travel_mm"),
        ({"speed_mm_s": 2.05}, "speed_mm_s"),
        ({"travel_mm": 5, "speed_mm_s": 0.05}, "travel_mm"),  # 104 s are more than the rig can hold
        ({"travel_mm": 1.55}, "plan"),
        ({"factors": {}, "conditions": []}, "plan"),
        ({"voltage": 3}, "voltage"),
        ({"substrate": "../brass"}, "substrate"),
    ],
)
def test_what_the_rig_cannot_do_is_refused_before_it_moves(change, key):
    with pytest.raises(InputError) as error:
        plan = make_plan({**document(), **change}, "plan")
        assert not plan.slots
    assert key in error.value.where or key == "plan"


def test_the_shipped_plan_is_one(tmp_path, pytestconfig):
    plan = read_plan(pytestconfig.rootpath / "config" / "plan.yaml")
    assert len(plan.slots) == 24
    assert plan.link.speed_factor == 1.0


def add(campaign, slot, minute, plan=None):
    run = slot.settings(datetime(2025, 1, 1, 10, minute))
    from eaclutch.rig.log_names import log_name

    name = log_name(run)
    (campaign / "tensile").mkdir(parents=True, exist_ok=True)
    (campaign / "tensile" / f"{name}.csv").write_text("Time\n")
    if plan:
        write_json(campaign / "capture" / f"{name}.json", {"plan": plan})
    return name


def test_the_campaign_says_what_is_missing(tmp_path):
    plan = make_plan(document(), "plan")
    assert missing_slots(plan, tmp_path) == list(plan.slots)
    first = add(tmp_path, plan.slots[0], 0, "p")
    elsewhere = add(tmp_path, plan.slots[1], 1)
    assert missing_slots(plan, tmp_path) == list(plan.slots[2:])
    assert missing_slots(plan, tmp_path, {first: "spoiled"}) == [plan.slots[0], *plan.slots[2:]]
    assert parse_log_name(elsewhere).voltage == plan.slots[1].setting.voltage
    own = make_plan(document(count_existing=False), "plan")
    assert missing_slots(own, tmp_path) == [own.slots[1], *own.slots[2:]]
    shutil.rmtree(tmp_path / "tensile")
    assert len(missing_slots(plan, tmp_path)) == 24


def test_suggestions_of_a_diagnosis_become_a_plan_of_new_runs(tmp_path):
    suggestion = {
        "voltage_v": 300,
        "frequency_hz": 1,
        "width_mm": 2,
        "preload_n": 0.1,
        "runs": 5,
        "information_nats": 1.9,
    }
    light = {**suggestion, "preload_n": None, "runs": 2}
    diagnosis = {"campaign": "c", "next_experiment": [suggestion, light]}
    made = plan_from_suggestions(diagnosis, "brass")
    plan = make_plan(made, "diagnosis")
    assert plan.name == "next-c"
    assert sorted(Counter(map(slot_key, plan.slots)).items()) == [
        ("dx=1.5_v=0.5_Fpre=-1g_V=300_f=1_w=2_brass", 2),
        ("dx=1.5_v=0.5_Fpre=10g_V=300_f=1_w=2_brass", 5),
    ]
    for minute, slot in enumerate(plan.slots):
        add(tmp_path, slot, minute)  # runs that were there before do not count
    assert len(missing_slots(plan, tmp_path)) == 7
    assert plan_from_suggestions(diagnosis, "brass", ["next-c"])["name"] == "next-c-2"
    with pytest.raises(InputError, match="suggests no experiment"):
        plan_from_suggestions({"campaign": "c", "next_experiment": []}, "brass")
    with pytest.raises(InputError, match="cannot be read"):
        plan_from_suggestions({"campaign": "c", "next_experiment": [{"voltage_v": 1}]}, "brass")
