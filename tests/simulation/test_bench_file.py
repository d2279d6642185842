from dataclasses import replace
from datetime import datetime
from pathlib import Path

from eaclutch.config import load_bench
from eaclutch.records import Bench, Drive, Gaussian, Pad, SessionSpan, Substrate
from eaclutch.simulation.bench_file import write_bench


def test_what_is_written_is_read_back(tmp_path: Path):
    bench = Bench(
        name="other",
        pad=Pad("parallel_plate", 28, 1.5e-3, 5e-4, 31e-6, 4e-2),
        film_density=1500.0,
        substrates={"steel": Substrate(7800.0, 1e-3, 0.08, {2.5e-3: 1e-3})},
        drive=Drive(2e-6, 3e-6),
        stage_speed=1e-3,
        sessions=(SessionSpan("one", datetime(2025, 1, 1, 8), datetime(2025, 1, 1, 9, 30)),),
        exclude={"run": "by hand"},
    )
    bench = replace(bench, load_cell=replace(bench.load_cell, mass=Gaussian(0.002, 1e-4)))
    write_bench(tmp_path, bench)
    found = load_bench(tmp_path)
    assert found.name == "other" and found.pad.type == "parallel_plate"
    for a, b in ((found.pad.film_thickness, 31e-6), (found.drive.rise_10_90, 2e-6), (found.stage_speed, 1e-3),
                 (found.load_cell.mass.mean, 0.002), (found.film_density, 1500.0)):  # fmt: skip
        assert abs(a - b) < 1e-9 * b
    assert found.sessions == bench.sessions and dict(found.exclude) == {"run": "by hand"}
    steel = found.substrates["steel"]
    assert [round(k * 1e3, 6) for k in steel.thickness] == [2.5]
