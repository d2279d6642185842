"""A log's name: what the operator set, in one place, both ways (contract: A campaign)."""

from __future__ import annotations

import re
from datetime import datetime
from pathlib import Path

from eaclutch.records import InputError, RunSettings

EXTENSIONS = (".csv", ".csv.gz", ".csv.xz", ".npy")
STANDARD_GRAVITY = 9.80665
_STAMP = "%Y%m%d_%H_%M_%S"
_NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_NAME = re.compile(
    r"(?P<stamp>\d{8}_\d{2}_\d{2}_\d{2})_bts"
    rf"_dx=(?P<travel>{_NUMBER})_v=(?P<speed>{_NUMBER})_Fpre=(?P<preload>{_NUMBER})g"
    rf"_V=(?P<voltage>{_NUMBER})_f=(?P<frequency>{_NUMBER})_w=(?P<width>{_NUMBER})"
    r"_(?P<substrate>[A-Za-z0-9][A-Za-z0-9.+-]{0,63})",
    re.ASCII,
)
# Limits that any bench of this kind keeps; a name outside them is a typing error, not a run.
_BOUNDS = {
    "travel": (0.0, 1000.0),
    "speed": (1e-6, 1000.0),
    "voltage": (0.0, 5000.0),
    "frequency": (1e-3, 1e6),
    "width": (0.01, 1000.0),
}


def run_of(path: Path | str) -> str:
    """The run's name: the file name without the log's extension, or the whole name if it has none."""
    name = Path(path).name
    for extension in sorted(EXTENSIONS, key=len, reverse=True):
        if name.endswith(extension):
            return name[: -len(extension)]
    return name


def parse_log_name(name: str) -> RunSettings:
    """Settings of a run from its log's name (with or without extension), in SI.

    Raises InputError where the name is not the rig's, or holds a value that no bench has.
    """
    run = run_of(name)
    found = _NAME.fullmatch(run)
    remedy = "name it <YYYYmmdd_HH_MM_SS>_bts_dx=<mm>_v=<mm/s>_Fpre=<number>g_V=<V>_f=<Hz>_w=<mm>_<substrate>"
    if found is None:
        raise InputError(_printable(name), "the name is not a log's name", remedy)
    try:
        stamp = datetime.strptime(found["stamp"], _STAMP)
    except ValueError:
        raise InputError(name, f"{found['stamp']} is not a date and time", remedy) from None
    value = {key: float(found[key]) for key in (*_BOUNDS, "preload")}
    for key, (low, high) in _BOUNDS.items():
        if not low <= value[key] <= high:
            raise InputError(name, f"{key} {found[key]} is outside {low:g} .. {high:g}", "correct the name")
    preload = None if value["preload"] == -1.0 else value["preload"] * 1e-3 * STANDARD_GRAVITY
    return RunSettings(
        run=run,
        stamp=stamp,
        travel=value["travel"] * 1e-3,
        speed=value["speed"] * 1e-3,
        preload=preload,
        voltage=value["voltage"],
        frequency=value["frequency"],
        width=value["width"] * 1e-3,
        substrate=found["substrate"],
    )


def log_name(settings: RunSettings) -> str:
    """The log's name (without extension) for these settings; ``settings.run`` is not looked at."""
    preload = -1.0 if settings.preload is None else settings.preload / (1e-3 * STANDARD_GRAVITY)
    return (
        f"{settings.stamp.strftime(_STAMP)}_bts_dx={_number(settings.travel * 1e3)}"
        f"_v={_number(settings.speed * 1e3)}_Fpre={_number(preload)}g_V={_number(settings.voltage)}"
        f"_f={_number(settings.frequency)}_w={_number(settings.width * 1e3)}_{settings.substrate}"
    )


def _number(value: float) -> str:
    return f"{value:.10g}"


def _printable(name: str) -> str:
    return "".join(character if character.isprintable() else "?" for character in str(name))[:200]
