from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from eaclutch.cli.simulation import simulate
from eaclutch.config.document import load_schema, read_yaml, with_defaults
from eaclutch.records import InputError
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.logs import read_log
from eaclutch.simulation.recipe import from_facts

ROOT = Path(__file__).resolve().parents[2]
SMALL = """
name: small
seed: 3
record: {before_s: 0.7, travel_mm: 0.1, after_s: 0.25, extension: .npy}
sessions: ["2025-03-03", "2025-03-05"]
repeats: 2
conditions:
  - {voltage_v: 300, frequency_hz: 1000, width_mm: 2, preload_n: 0.1}
  - {voltage_v: 300, frequency_hz: 10, width_mm: 2, preload_n: 0.1, sessions: [1]}
effects: {series_compliance: {compliance: 2.0e-5}}
side: {capacitance_trials: 0, permittivity_sources: 0, load_cell_logs: 0}
"""


def _facts(**changes) -> dict:
    facts = with_defaults({"conditions": [{"voltage_v": 300, "frequency_hz": 1, "width_mm": 2, "preload_n": 0.1}]},
                          load_schema("recipe"))  # fmt: skip
    return facts | changes


def test_command_makes_a_campaign_and_does_not_overwrite(tmp_path: Path):
    recipe, output = tmp_path / "small.yaml", tmp_path / "out" / "small"
    recipe.write_text(SMALL)
    arguments = ["--recipe", str(recipe), "--output", str(output)]
    result = CliRunner().invoke(simulate, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    logs = open_campaign(output).logs
    assert len(logs) == 4
    low = [log.settings.stamp.day for log in logs if log.settings.frequency == 10]
    assert low == [5, 5]
    with pytest.raises(InputError, match="not empty"):
        CliRunner().invoke(simulate, arguments, catch_exceptions=False)
    content = {log.path.name: log.path.read_bytes() for log in logs}
    CliRunner().invoke(simulate, [*arguments, "--replace"], catch_exceptions=False)
    assert {log.path.name: log.path.read_bytes() for log in open_campaign(output).logs} == content
    assert sorted(p.name for p in output.parent.iterdir()) == ["small"]


def test_effects_take_given_values_and_draw_the_rest():
    made = from_facts(_facts(effects={"trapped_charge": {"decay_time": 0.02}}), np.random.default_rng(1))
    assert "trapped_charge" in made.effects
    assert made.parameters["trapped_charge.decay_time"] == 0.02
    assert made.parameters["trapped_charge.residual_fraction"] > 0


def test_a_base_effect_can_be_left_out():
    made = from_facts(_facts(without=["squeeze_film"]), np.random.default_rng(1))
    assert "squeeze_film" not in made.effects and "air_gap" in made.effects


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"effects": {"gremlins": {}}}, "gremlins"),
        ({"effects": {"gas_slip": {"size": 1.0}}}, "size"),
        ({"without": ["gas_slip"]}, "gas_slip"),
        ({"noise": {"pink": 1.0}}, "pink"),
        ({"noise": {"white": -0.5}}, "white"),
        ({"sessions": ["2025-02-30"]}, "2025-02-30"),
    ],
)
def test_unknown_names_are_refused(changes: dict, named: str):
    with pytest.raises(InputError, match=named):
        from_facts(_facts(**changes), np.random.default_rng(1))


def test_the_fixture_and_its_twin_differ_by_the_effect_alone():
    facts, twin = (read_yaml(ROOT / "data" / f"{name}.yaml") for name in ("fixture", "fixture-null"))
    assert facts["conditions"] == twin["conditions"] and facts["record"] == twin["record"]
    assert set(facts) - set(twin) == {"effects"}


def test_the_fixture_is_what_its_recipe_makes():
    facts = with_defaults(read_yaml(ROOT / "data" / "fixture.yaml"), load_schema("recipe"))
    made = from_facts(facts, np.random.default_rng(facts["seed"]))
    stamps = sorted(run.stamp for run in made.plan.runs)
    logs = open_campaign(ROOT / "data" / "fixture").logs
    assert [log.settings.stamp for log in logs] == stamps
    assert sum(path.stat().st_size for path in (ROOT / "data" / "fixture").rglob("*") if path.is_file()) < 6e6


def test_the_fixture_holds_what_the_library_simulates_now(tmp_path: Path):
    """A law that changed shows here: mend by making the fixture anew (data/README.md)."""
    recipe = tmp_path / "fixture.yaml"
    text = (ROOT / "data" / "fixture.yaml").read_text().replace("contact_s:", "extension: .npy, contact_s:")
    recipe.write_text(text)
    arguments = ["--recipe", str(recipe), "--output", str(tmp_path / "fixture")]
    CliRunner().invoke(simulate, arguments, catch_exceptions=False)
    for log in open_campaign(ROOT / "data" / "fixture").logs[::4]:
        kept, fresh = (
            read_log(log.path),
            read_log(tmp_path / "fixture" / "tensile" / f"{log.settings.run}.npy"),
        )
        np.testing.assert_allclose(kept.time, fresh.time, atol=1e-9)
        apart = np.abs(kept.force - fresh.force)
        assert np.quantile(apart, 0.98) < 2e-4, log.settings.run
