"""However large a campaign is, its data vector is not."""

import pandas as pd

from eaclutch.diagnosis.condense import MOST_ENTRIES, condense


def campaign(conditions, sessions):
    return pd.DataFrame(
        [
            {"run": f"{s:04d}-{c:04d}", "condition": f"c{c}", "session": f"day {s:03d}"}
            for s in range(sessions)
            for c in range(conditions)
        ]
    )


def groups(table):
    return len(table[["condition", "session"]].drop_duplicates())


def test_a_campaign_that_fits_is_left_alone():
    table = campaign(20, 3)
    found, notes = condense(table, 10)
    assert found is table and notes == ()


def test_consecutive_sessions_are_taken_together_and_no_run_is_lost():
    table = campaign(20, 300)
    found, notes = condense(table, 10)
    assert groups(found) * 10 <= MOST_ENTRIES
    assert list(found["run"]) == list(table["run"])
    assert next(iter(dict.fromkeys(found["session"]))) == "day 000 to day 042"
    assert notes[0].startswith("300 sessions are taken together as 7: ")


def test_conditions_with_the_fewest_runs_are_left_out_and_counted():
    table = pd.concat([campaign(400, 1), campaign(100, 1)], ignore_index=True)
    found, notes = condense(table, 10)
    assert {f"c{i}" for i in range(100)} <= set(found["condition"])
    assert found["condition"].nunique() == MOST_ENTRIES // 10
    assert notes == ("the 250 of 400 conditions with the fewest runs are left out",)


def test_sessions_stay_where_conditions_alone_would_fill_all():
    found, notes = condense(campaign(200, 60), 10)
    assert groups(found) * 10 <= MOST_ENTRIES and found["session"].nunique() == 3
    assert len(notes) == 2


def test_runs_of_sessions_taken_together_keep_their_order():
    table = campaign(20, 300).assign(run_order=lambda t: t.groupby("session").cumcount())
    found, _ = condense(table, 10)
    for _, part in found.sort_values("run").groupby("session"):
        assert list(part["run_order"]) == list(range(len(part)))
