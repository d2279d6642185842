"""campaign.yaml of a simulated campaign: the bench's facts in the units of the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from eaclutch.files import write_text
from eaclutch.records import Bench, Gaussian


def bench_facts(bench: Bench) -> dict[str, Any]:
    """The facts of ``bench`` as campaign.yaml states them (contract: A campaign)."""

    def plain(value: float) -> float:
        return float(f"{value:.10g}")

    def pair(gaussian: Gaussian) -> list[float]:
        return [plain(gaussian.mean), plain(gaussian.sd)]

    pad, fixture, friction, cell = bench.pad, bench.fixture, bench.friction, bench.load_cell
    facts: dict[str, Any] = {
        "name": bench.name,
        "pad": {
            "type": pad.type,
            "electrodes": pad.electrodes,
            "electrode_length_mm": plain(pad.electrode_length * 1e3),
            "electrode_gap_mm": plain(pad.electrode_gap * 1e3),
            "film_thickness_um": plain(pad.film_thickness * 1e6),
            "overlap_length_mm": plain(pad.overlap_length * 1e3),
        },
        "film": {"density_kg_m3": plain(bench.film_density)},
        "capacitance_fixture": {
            "overlap_length_mm": plain(fixture.overlap_length * 1e3),
            "meter_frequency_hz": plain(fixture.meter_frequency),
            "stray_capacitance_pf": plain(fixture.stray_capacitance * 1e12),
        },
        "substrates": {
            name: {
                "density_kg_m3": plain(substrate.density),
                "extra_mass_kg": plain(substrate.extra_mass),
                "length_mm": plain(substrate.length * 1e3),
                "thickness_mm": {
                    plain(width * 1e3): plain(value * 1e3) for width, value in substrate.thickness.items()
                },
            }
            for name, substrate in bench.substrates.items()
        },
        "friction": {
            "base": {"static": pair(friction.base_static), "kinetic": pair(friction.base_kinetic)},
            "film": {"static": pair(friction.film_static), "kinetic": pair(friction.film_kinetic)},
        },
        "load_cell": {
            "stiffness_n_m": pair(cell.stiffness),
            "mass_kg": pair(cell.mass),
            "damping_kg_s": pair(cell.damping),
        },
        "drive": {
            "rise_10_90_us": plain(bench.drive.rise_10_90 * 1e6),
            "fall_90_10_us": plain(bench.drive.fall_90_10 * 1e6),
        },
        "stage_speed_mm_s": plain(bench.stage_speed * 1e3),
        "exclude": dict(bench.exclude),
    }
    stamp = "%Y%m%d_%H_%M_%S"
    facts["sessions"] = (
        "by_date"
        if bench.sessions is None
        else [
            {"name": span.name, "from": span.start.strftime(stamp), "to": span.end.strftime(stamp)}
            for span in bench.sessions
        ]
    )
    return facts


def write_bench(folder: Path, bench: Bench) -> None:
    """Write ``<folder>/campaign.yaml``."""
    text = yaml.safe_dump(bench_facts(bench), sort_keys=False, default_flow_style=None, width=120)
    write_text(folder / "campaign.yaml", text)
