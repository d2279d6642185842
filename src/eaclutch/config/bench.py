"""campaign.yaml: the bench's facts, from the units of the file to SI."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from eaclutch.config.document import check, load_schema, read_yaml, with_defaults
from eaclutch.records import (
    Bench,
    CapacitanceFixture,
    Drive,
    Friction,
    Gaussian,
    InputError,
    LoadCell,
    Pad,
    SessionSpan,
    Substrate,
)

NAME = "campaign.yaml"
_STAMP = re.compile(r"^\d{8}_\d{2}_\d{2}_\d{2}$")


def load_bench(folder: str | Path) -> Bench:
    """Read and check ``<folder>/campaign.yaml``; what it leaves out takes the published value.

    Raises InputError that names the file and the key.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(
            folder, "there is no such campaign folder", "point campaign at a folder of recordings"
        )
    path = folder / NAME
    if path.is_symlink() and not path.resolve().is_relative_to(folder.resolve()):
        raise InputError(path, "is a link out of the campaign", "put the file itself there")
    document = read_yaml(path)
    check(document, "campaign", path)
    return bench_from_facts(with_defaults(document, load_schema("campaign")), path)


def bench_from_facts(facts: Mapping[str, Any], where: Path) -> Bench:
    """The bench from checked and completed facts; ``where`` is the file they stand in."""
    pad = facts["pad"]
    fixture = facts["capacitance_fixture"]
    name = facts.get("name", where.resolve().parent.name)
    if not re.fullmatch(r"[A-Za-z0-9_-]{1,64}", name):
        raise InputError(
            f"{where}, name",
            f"the folder's name {name!r} cannot name a campaign",
            "add a name of letters, digits, _ and -",
        )
    return Bench(
        name=name,
        pad=Pad(
            type=pad["type"],
            electrodes=int(pad["electrodes"]),
            electrode_length=pad["electrode_length_mm"] * 1e-3,
            electrode_gap=pad["electrode_gap_mm"] * 1e-3,
            film_thickness=pad["film_thickness_um"] * 1e-6,
            overlap_length=pad["overlap_length_mm"] * 1e-3,
        ),
        film_density=float(facts["film"]["density_kg_m3"]),
        fixture=CapacitanceFixture(
            overlap_length=fixture["overlap_length_mm"] * 1e-3,
            meter_frequency=float(fixture["meter_frequency_hz"]),
            stray_capacitance=fixture["stray_capacitance_pf"] * 1e-12,
        ),
        substrates={
            key: _substrate(value, f"{where}, substrates.{key}") for key, value in facts["substrates"].items()
        },
        friction=_friction(facts["friction"]),
        load_cell=_load_cell(facts["load_cell"]),
        drive=Drive(facts["drive"]["rise_10_90_us"] * 1e-6, facts["drive"]["fall_90_10_us"] * 1e-6),
        stage_speed=facts["stage_speed_mm_s"] * 1e-3,
        sessions=_sessions(facts["sessions"], where),
        exclude=dict(facts["exclude"]),
    )


def _substrate(facts: Mapping[str, Any], where: str) -> Substrate:
    thickness = {}
    for width, value in facts["thickness_mm"].items():
        try:
            millimetres = float(width)
        except ValueError:
            millimetres = float("nan")
        if not 0 < millimetres <= 1000:
            raise InputError(
                f"{where}.thickness_mm.{width}", "is not a width in mm", "give a number, 0 to 1000"
            )
        thickness[millimetres * 1e-3] = value * 1e-3
    return Substrate(
        density=float(facts["density_kg_m3"]),
        extra_mass=float(facts["extra_mass_kg"]),
        length=facts["length_mm"] * 1e-3,
        thickness=thickness,
    )


def _friction(facts: Mapping[str, Any]) -> Friction:
    published = Friction()
    given = {
        f"{surface}_{kind}": Gaussian(*map(float, pair))
        for surface, kinds in facts.items()
        for kind, pair in kinds.items()
    }
    return Friction(
        **{name: given.get(name, getattr(published, name)) for name in Friction.__dataclass_fields__}
    )


def _load_cell(facts: Mapping[str, Any]) -> LoadCell:
    published = LoadCell()
    keys = {"stiffness": "stiffness_n_m", "mass": "mass_kg", "damping": "damping_kg_s"}
    return LoadCell(
        **{
            name: Gaussian(*map(float, facts[key])) if key in facts else getattr(published, name)
            for name, key in keys.items()
        }
    )


def _sessions(spans: Any, where: Path) -> tuple[SessionSpan, ...] | None:
    if spans == "by_date":
        return None
    found: list[SessionSpan] = []
    for index, span in enumerate(spans):
        key = f"{where}, sessions[{index}]"
        start = _moment(span["from"], f"{key}.from", end=False)
        end = _moment(span["to"], f"{key}.to", end=True)
        if end < start:
            raise InputError(key, "ends before it begins", "swap from and to")
        for other in found:
            if span["name"] == other.name:
                raise InputError(key, f"the name {other.name} stands twice", "give each session its own name")
            if start <= other.end and other.start <= end:
                raise InputError(key, f"overlaps the session {other.name}", "keep sessions apart")
        found.append(SessionSpan(span["name"], start, end))
    return tuple(found)


def _moment(given: str | int, where: str, *, end: bool) -> datetime:
    """A date (its last microsecond where it ends a span) or a full stamp."""
    text = str(given)
    try:
        if _STAMP.match(text):
            return datetime.strptime(text, "%Y%m%d_%H_%M_%S")
        if re.fullmatch(r"\d{8}", text):
            text = f"{text[:4]}-{text[4:6]}-{text[6:]}"
        moment = datetime.fromisoformat(text)
    except ValueError:
        raise InputError(
            where, f"{text!r} is neither a date nor a stamp", "write 2024-11-03 or 20241103_16_20_52"
        ) from None
    if moment.tzinfo is not None:
        raise InputError(where, "has a time zone", "give the rig's local time without one")
    whole_day = len(text) == 10
    return moment + timedelta(days=1, microseconds=-1) if end and whole_day else moment
