"""Files of the side benches and of the capture that hold what is no number, or are nested without end."""

from __future__ import annotations

from pathlib import Path

from hostile_campaigns.sound import NAME, base, case


@case
def spectrum_not_finite(folder: Path) -> None:
    base(folder)
    (folder / "permittivity" / "s.csv").write_text(
        "frequency_hz,relative_permittivity\n1,inf\n-5,nan\n0,1e400\n"
    )


@case
def capacitance_not_finite(folder: Path) -> None:
    base(folder)
    text = "force_n,capacitance_pf,width_mm,trial\n" + "nan,inf,2,a\n1e308,1e-320,0,a\n" * 10
    (folder / "capacitance" / "c.csv").write_text(text)


@case
def load_cell_not_finite(folder: Path) -> None:
    base(folder)
    text = "Time,Load Cell,Moving Forward\n" + "nan,inf,-inf\n" * 65_000
    (folder / "load_cell" / "20250101_10_00_00_calibrate_loadcell_damper_dx=1_speed=1mms.csv").write_text(
        text
    )


@case
def record_of_capture_is_nested(folder: Path) -> None:
    base(folder)
    (folder / "capture").mkdir()
    (folder / "capture" / f"{NAME}.json").write_text("[" * 90_000)
