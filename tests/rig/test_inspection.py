"""What an experimenter looks at first: a table with uncertainties, and a picture."""

from __future__ import annotations

import numpy as np
from click.testing import CliRunner

from eaclutch.cli.rig import inspect as command
from eaclutch.records import Bench
from eaclutch.rig.inspection import inspect, measured
from eaclutch.rig.logs import write_log
from eaclutch.rig.observables import OBSERVABLES
from rig.made_run import Made, make_run


def test_numbers_carry_two_digits_of_their_uncertainty():
    assert measured(0.123456, 0.00234) == "0.1235 +- 0.0023"
    assert measured(1234.5, 56.7) == "1234 +- 57"
    assert measured(float("nan"), 1.0) is None


def test_every_observable_has_a_line_with_a_value_or_its_reason():
    seen = inspect(make_run(Made(travel=1e-4, after=0.5), np.random.default_rng(0))[0], Bench("test"))
    for name in OBSERVABLES:
        line = next(line for line in seen.table.splitlines() if f"{name} " in line)
        assert ("+-" in line) == (name in seen.values) and ("none: " in line) == (name not in seen.values)
    assert "no_zero" in seen.table and {"on", "off"} <= seen.instants.keys()


def test_command_prints_the_table_and_draws(tmp_path):
    for name, change in (("driven", {}), ("dead", {"voltage": 0.0})):
        recording = make_run(Made(travel=1e-4, after=0.5, **change), np.random.default_rng(0))[0]
        log = write_log(recording, tmp_path / f"{recording.settings.run}.csv.gz")
        picture = tmp_path / f"{name}.png"
        done = CliRunner().invoke(command, [str(log), "--output", str(picture)])
        assert done.exit_code == 0, done.output
        assert "usable" in done.output and picture.read_bytes().startswith(b"\x89PNG")
