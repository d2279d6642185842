"""The config: merging, paths, names of effects, messages, and its README."""

from __future__ import annotations

from pathlib import Path

import pytest

from eaclutch.config import effect_names, load_config
from eaclutch.config.document import load_schema
from eaclutch.config.readme import config_readme
from eaclutch.config.slices import bench_slice, job_seed
from eaclutch.physics.effects import EFFECTS
from eaclutch.records import Bench, InputError

ROOT = Path(__file__).resolve().parents[2]


def test_later_files_win_key_by_key_and_overrides_win_over_all(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("seed: 1\nposterior: {walkers: 40, ensembles: 5}\n")
    (tmp_path / "b.yaml").write_text("posterior: {walkers: 50}\n")
    config = load_config([tmp_path / "a.yaml", tmp_path / "b.yaml"], {"seed": 7})
    assert (config["seed"], config["posterior"]["walkers"], config["posterior"]["ensembles"]) == (7, 50, 5)
    assert (
        config["predict"]["draws"]
        == load_schema("config")["properties"]["predict"]["properties"]["draws"]["default"]
    )


def test_texts_within_braces_on_the_command_line_are_read() -> None:
    config = load_config((), {"observables": {"batch_size": "7", "preload_bin_edges_n": ["0.5", "1e0"]}})
    assert config["observables"]["batch_size"] == 7
    assert config["observables"]["preload_bin_edges_n"] == [0.5, 1.0]


def test_a_relative_path_belongs_to_the_file_that_states_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "a.yaml").write_text("campaign: ../recordings\n")
    monkeypatch.chdir(tmp_path)
    stated = load_config(["folder/a.yaml"])["campaign"]
    assert Path(stated).resolve() == (tmp_path / "recordings").resolve()
    assert load_config(["folder/a.yaml"], {"campaign": "mine"})["campaign"] == str(tmp_path / "mine")


def test_the_effects_on_offer_are_the_library() -> None:
    assert set(effect_names()) == set(EFFECTS)


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ("posterior: {walker: 3}", ("posterior.walker", "not a known key", "walkers")),
        ("posterior: {walkers: many}", ("posterior.walkers", "integer")),
        ("posterior: {walkers: 2}", ("posterior.walkers", "at least 8")),
        ("model: {without: [air_gpa]}", ("model.without", "air_gpa", "air_gap")),
        ("model: {effects: [air_gap], without: [air_gap]}", ("model.without", "air_gap")),
        ("diagnosis: {candidates: [ghosts]}", ("diagnosis.candidates", "ghosts")),
        ("observables: {preload_bin_edges_n: [1, 0.5]}", ("preload_bin_edges_n", "increase")),
        ("priors: {mass: [1, 0]}", ("priors.mass[1]", "above 0")),
        ("seed: .nan", ("seed", "finite")),
    ],
)
def test_one_line_names_file_key_and_remedy(tmp_path: Path, document: str, words: tuple[str, ...]) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(document)
    with pytest.raises(InputError) as caught:
        load_config([path])
    line = str(caught.value)
    assert "\n" not in line and "mine.yaml" in line
    for word in words:
        assert word in line


def test_a_missing_config_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.yaml: there is no such file"):
        load_config([tmp_path / "none.yaml"])


def test_the_readme_is_the_schema() -> None:
    assert (ROOT / "config" / "README.md").read_text() == config_readme(), "run: eaclutch config-readme"


@pytest.mark.parametrize("name", ["config.yaml", "published.yaml", "rig.yaml"])
def test_the_configs_that_come_along_are_valid(name: str) -> None:
    assert load_config([ROOT / "config" / name])["seed"] >= 0


def test_slices_change_only_with_what_they_name() -> None:
    bench = Bench(name="a")
    other = Bench(name="a", stage_speed=1e-3)
    assert bench_slice(bench, ["pad", "drive"]) == bench_slice(other, ["pad", "drive"])
    assert bench_slice(bench, ["stage_speed"]) != bench_slice(other, ["stage_speed"])
    assert bench_slice(bench, []) != bench_slice(other, [])


def test_seeds_differ_by_label_and_repeat() -> None:
    assert job_seed(1, ["posterior", "contact"]) == job_seed(1, ["posterior", "contact"])
    assert len({job_seed(1, ["a", "b"]), job_seed(1, ["ab"]), job_seed(2, ["a", "b"])}) == 3
