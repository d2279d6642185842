"""The authors' own values come out of the published definitions, run by run."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from eaclutch.config import load_bench
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.extract import extract
from eaclutch.rig.logs import read_log
from eaclutch.rig.published import COLUMNS
from eaclutch.rig.published import published as by_definition
from rig.made_run import STEP, Made, make_run, release_time


@pytest.mark.published
def test_authors_values_are_reproduced(published):
    logs = open_campaign(published).logs
    ours = pd.DataFrame([by_definition(read_log(log.path)) for log in logs]).set_index("run")
    authors = pd.read_csv(published / "authors_runs.csv").set_index("run")
    assert set(ours.index[ours["kept"]]) == set(authors.index)
    difference = (ours.loc[authors.index, authors.columns] - authors).abs().max()
    assert difference["engagement_us"] < 0.05
    assert difference[["release_90_ms", "release_10_ms"]].max() < STEP * 1e3
    forces = ["force_at_switch_off_n", "force_before_voltage_n", "force_max_n"]
    assert difference[forces].max() < 1e-5


@pytest.mark.published
def test_broken_published_runs_are_flagged_and_whole_ones_are_not(published):
    bench = load_bench(published)
    flags = {}
    for log in open_campaign(published).logs:
        stamp = log.settings.run[:17]
        if stamp in EXPECTED:
            flags[stamp] = extract(read_log(log.path), bench)["flags"].split(";")
    for stamp, flag in EXPECTED.items():
        assert flag in flags[stamp], stamp


EXPECTED = {
    "20241103_15_53_31": "force_realigned_from_release",
    "20241103_16_20_52": "force_in_step_until_release",
    "20241103_16_06_23": "force_not_in_step",
    "20241103_17_15_12": "time_realigned",
    "20241103_18_25_23": "force_glitch",
    "20241103_16_02_24": "voltage_lines_lost",
    "20241029_15_31_38": "no_voltage",
}


def test_definitions_on_a_made_run():
    made = Made(capacity=0.5, hold=0.5, white=1e-4, mains=0.0, pick_up=0.0, delay=0.3e-3, fall=0.8e-3)
    row = by_definition(make_run(made, np.random.default_rng(0))[0])
    assert tuple(row) == COLUMNS
    # first sample below the level, later than the first sample after the fall of the voltage
    for name, share in (("release_90_ms", 0.9), ("release_10_ms", 0.1)):
        assert row[name] * 1e-3 == pytest.approx(release_time(made, share), abs=2.1 * STEP)
    assert row["force_at_switch_off_n"] == pytest.approx(0.62, abs=2e-3)
    assert row["force_before_voltage_n"] == pytest.approx(0.12, abs=1e-3)


def test_what_the_published_rules_leave_out_has_its_reason():
    dead, _, _ = make_run(Made(voltage=10.0), np.random.default_rng(1))
    assert by_definition(dead)["reason"] == "no_voltage"
    early, _, _ = make_run(Made(capacity=0.5, hold=0.0, frequency=0.1), np.random.default_rng(1))
    row = by_definition(early)
    assert not row["kept"] and row["reason"] == "released_early"
