"""Campaign folders, batches, runs.csv, and the model's inputs from it."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from eaclutch.files import write_csv
from eaclutch.records import Bench, InputError, SessionSpan, Substrate
from eaclutch.rig.batch import extract_batch, join_batches
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.log_names import parse_log_name
from eaclutch.rig.logs import write_log
from eaclutch.rig.observables import OBSERVABLES
from eaclutch.rig.preload import preload_of
from eaclutch.rig.table import LEADING, conditions_from_runs, observables_markdown, preload_bin, session_of
from rig.made_run import Made, make_run, settings_of

BENCH = Bench(
    "test", substrates={"brass": Substrate(density=8338.5, extra_mass=0.000726, thickness={2e-3: 2e-3})}
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "tensile").mkdir()
    (folder / "campaign.yaml").write_text("name: made\n")
    stamps = [datetime(2024, 11, 3, 15, 10), datetime(2024, 11, 3, 15, 5), datetime(2024, 11, 4, 9, 0)]
    for seed, (stamp, voltage) in enumerate(zip(stamps, (300.0, 300.0, 0.0), strict=True)):
        made = Made(voltage=voltage, after=0.5, travel=2e-4, friction=0.05)
        recording = replace(make_run(made, np.random.default_rng(seed))[0], settings=settings_of(made, stamp))
        write_log(recording, folder / "tensile" / f"{recording.settings.run}.npy")
    return folder


def test_batches_join_to_the_contracts_table(folder, tmp_path):
    logs = [log.path for log in open_campaign(folder).logs]
    excluded = logs[1].name[: -len(".npy")]
    bench = replace(BENCH, exclude={excluded: "a trial"})
    tables = []
    for number, part in enumerate((logs[:1], logs[1:])):
        write_csv(tmp_path / f"{number}.csv", pd.DataFrame(extract_batch(part, bench).runs))
        tables.append(pd.read_csv(tmp_path / f"{number}.csv"))
    runs, quality = join_batches(tables, bench)
    assert tuple(runs.columns[: len(LEADING)]) == LEADING
    assert [f"{name}_sd" in runs.columns for name in OBSERVABLES] == [True] * len(OBSERVABLES)
    assert list(runs["run"]) == sorted(runs["run"]) and len(runs) == 3
    assert list(runs["session"]) == ["2024-11-03", "2024-11-03", "2024-11-04"]
    assert list(runs["run_order"]) == [0, 1, 0]
    assert list(runs["usable"]) == [True, False, False]
    assert quality["flags"]["excluded"] == 1 and quality["excluded"] == {excluded: "a trial"}
    assert quality["flags"]["no_voltage"] == 1 and quality["usable"] == 1
    assert runs["condition"][0].startswith("brass_w2_t2_300V_1000Hz_p")
    conditions = conditions_from_runs(runs)
    assert conditions.run == (runs["run"][0],)
    assert conditions.drive_duration[0] == pytest.approx(0.4, abs=6e-4) and conditions.thickness[0] == 2e-3
    assert conditions.friction_before[0] == pytest.approx(runs["friction_before_n"][0])


def test_runs_of_a_batch_say_how_the_drive_of_another_ends(tmp_path):
    """Three whose sensed wave is cut short with the flag, and one whose flag falls in the other electrode's wave."""
    paths = []
    for seed, last in enumerate(("sensed", "sensed", "sensed", "grounded")):
        made = Made(after=0.5, travel=2e-4, friction=0.05, delay=0.3e-3)
        recording, on, off = make_run(made, np.random.default_rng(seed))
        driven = recording.flag > 0.5
        waves = np.floor((recording.time - on + 0.3e-3) / 0.5e-3).astype(int)
        high = driven & ((waves[driven][-1] - waves) % 2 == (last == "grounded"))
        recording = replace(
            recording,
            voltage=np.where(high, 300.0, 2.0),
            settings=settings_of(made, datetime(2024, 11, 3, 15, seed)),
        )
        paths.append(tmp_path / f"{recording.settings.run}.npy")
        write_log(recording, paths[-1])
    alone, (*_, together) = extract_batch(paths[3:], BENCH).runs[0], extract_batch(paths, BENCH).runs
    assert "voltage_off_unsure" in alone["flags"] and "voltage_off_unsure" not in together["flags"]
    assert together["drive_duration_s"] == pytest.approx(off - on, abs=8e-5)
    assert alone["drive_duration_s"] - together["drive_duration_s"] == pytest.approx(1e-4, abs=4e-5)
    assert together["release_time_50_s_sd"] < 0.6 * alone["release_time_50_s_sd"]


def test_a_run_in_two_formats_and_no_run_are_errors(folder, tmp_path):
    path = next((folder / "tensile").iterdir())
    twin = path.with_suffix(".csv")
    twin.write_text("x")
    try:
        with pytest.raises(InputError, match="keep one of the two"):
            open_campaign(folder)
    finally:
        twin.unlink()
    with pytest.raises(InputError, match="holds no log"):
        open_campaign(tmp_path)
    with pytest.raises(InputError, match="not a folder"):
        open_campaign(tmp_path / "nowhere")


def test_links_out_of_the_campaign_are_refused(folder, tmp_path):
    source = next((folder / "tensile").iterdir())
    (tmp_path / "tensile").mkdir()
    (tmp_path / "tensile" / source.name).symlink_to(source)
    with pytest.raises(InputError, match="leads out"):
        open_campaign(tmp_path)


def test_preload_is_estimated_from_friction_as_the_bench_weighs():
    """F_pre = (F - mu_b m_s g - mu_d m_d g) / (mu_d + mu_b), worked by hand for a 2 x 2 x 100 mm strip."""
    settings = settings_of(Made())
    substrate, film = 8338.5 * 0.1 * 4e-6 + 0.000726, 1780 * 24e-6 * 55.5e-3 * 2e-3
    expected = (0.2 - 9.80665 * (0.173 * substrate + 0.154 * film)) / (0.173 + 0.154)
    assert preload_of(0.2, settings, BENCH) == pytest.approx(expected, rel=1e-9)
    with pytest.raises(InputError, match="glass"):
        preload_of(0.2, replace(settings, substrate="glass"), BENCH)


def test_sessions_and_bins():
    span = SessionSpan("morning", datetime(2024, 11, 3), datetime(2024, 11, 3, 12))
    bench = replace(BENCH, sessions=(span,))
    assert session_of(datetime(2024, 11, 3, 12), bench) == "morning"
    assert session_of(datetime(2024, 11, 3, 13), bench) == "2024-11-03"
    assert [preload_bin(value) for value in (-0.1, 0.25, 0.8, 9.0, np.nan)] == [
        "0-0.25N", "0.25-0.75N", "0.75-1.5N", "1.5-infN", "unknown"
    ]  # fmt: skip
    assert parse_log_name(
        "20240101_00_00_00_bts_dx=1.5_v=0.5_Fpre=50g_V=300_f=0.1_w=2_brass"
    ).preload == pytest.approx(0.4903325)


def test_documented_observables_are_those_of_the_code():
    page = (Path(__file__).resolve().parents[2] / "docs" / "observables.md").read_text(encoding="utf-8")
    assert observables_markdown() in page
