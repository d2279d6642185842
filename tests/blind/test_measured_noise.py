"""The noise statistics find what was put in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from eaclutch.blind.measured_noise import measure_noise, zeros_at_end
from eaclutch.records import InputError, Recording
from eaclutch.rig.logs import parse_log_name, write_log


def log(folder: Path, minute: int, lost: int) -> Path:
    rng = np.random.default_rng(minute)
    settings = parse_log_name(f"20250101_10_{minute:02d}_00_bts_dx=1.5_v=0.5_Fpre=-1g_V=300_f=1000_w=2_brass")
    time = 78e-6 * np.arange(40_000)
    force = (
        0.04
        + 0.011 * rng.standard_normal(len(time))
        + 0.008 * np.sin(2 * np.pi * 50 * 12_800 / 12_820.5 * time)
    )
    force[len(force) - lost :] = 0.0
    flag = (time > 2.0).astype(float)
    return write_log(Recording(settings, time, force, flag, 300 * flag), folder / f"{settings.run}.npy")


def test_white_noise_mains_and_lost_lines_are_found(tmp_path: Path) -> None:
    found = measure_noise([log(tmp_path, 1, 0), log(tmp_path, 2, 0), log(tmp_path, 3, 900)])["2025-01-01"]
    assert found["white_sd_n"][0] == pytest.approx(0.011, rel=0.05)
    assert found["mains_50_hz_n"][0] == pytest.approx(0.008, rel=0.15)
    assert found["line_400_hz_n"][0] < 0.001
    assert found["force_lost_share"] == pytest.approx(1 / 3)
    assert found["lost_lines_median"] == 900


def test_a_column_of_zeros_is_all_lost() -> None:
    assert zeros_at_end(np.zeros(7)) == 7
    assert zeros_at_end(np.array([0.0, 2.0])) == 0


def test_no_log_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no log"):
        measure_noise([])
