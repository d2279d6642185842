"""What all hostile campaigns start from: a sound one, under whose name each puts its own harm."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

NAME = "20250101_10_00_00_bts_dx=1.5_v=0.5_Fpre=-1g_V=300_f=1000_w=2_brass"
HEADER = "Time,Load Cell,Moving Forward,Relay Output\n"
CASES: dict[str, Callable[[Path], None]] = {}
BOMB_MEGABYTES = 1500


def case(build: Callable[[Path], None]) -> Callable[[Path], None]:
    """Register a hostile campaign under its function's name."""
    CASES[build.__name__] = build
    return build


def sound_log(rows: int = 20_000) -> str:
    """A log that is one, so that the rest of a campaign gets read."""
    time_us = 800 + 78 * np.arange(rows)
    flag = ((time_us > 3e5) & (time_us < 1.2e6)).astype(float)
    force = 0.1 + 0.5 * flag
    lines = [
        f"{t}.0,{f!r},{g!r},{300 * g!r}"
        for t, f, g in zip(time_us, force.tolist(), flag.tolist(), strict=True)
    ]
    return HEADER + "\n".join(lines) + "\n"


def base(folder: Path, facts: str = "name: hostile\n", log: bool = True) -> Path:
    """A campaign folder with facts and one sound log."""
    for part in ("tensile", "capacitance", "permittivity", "load_cell"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    (folder / "campaign.yaml").write_text(facts)
    if log:
        (folder / "tensile" / f"{NAME}.csv").write_text(sound_log())
    return folder
