"""The plan of a capture session: conditions x repeats in a seeded random order, within the rig's limits."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from eaclutch.config.document import check, load_schema, read_yaml, with_defaults
from eaclutch.records import InputError, RunSettings
from eaclutch.rig.link.protocol import BenchSetting, Command, Timing
from eaclutch.rig.link.reader import LinkSettings
from eaclutch.rig.link.transfer import Grid
from eaclutch.rig.log_names import STANDARD_GRAVITY, log_name

_GRAM = 1e-3 * STANDARD_GRAVITY
_DEFAULT_LEVELS = {"voltage_v": 300.0, "frequency_hz": 1000.0, "width_mm": 2.0, "preload_g": -1.0}
_ANY_STAMP = datetime(2000, 1, 1)


@dataclass(frozen=True)
class Slot:
    """One run of the plan: what the operator sets, what the rig is told, which repeat it is (from 0)."""

    setting: BenchSetting
    command: Command
    repeat: int

    def settings(self, stamp: datetime) -> RunSettings:
        """What the name of a run captured at ``stamp`` says."""
        bench, command = self.setting, self.command
        return RunSettings(
            "", stamp, command.travel, command.speed, bench.preload, bench.voltage, bench.frequency,
            bench.width, bench.substrate,
        )  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """A plan that was read and is within the rig's limits; ``slots`` in the order of capture."""

    name: str
    slots: tuple[Slot, ...]
    timing: Timing
    link: LinkSettings
    grid: Grid
    voltage_tolerance: float
    retries: int
    log_format: str
    count_existing: bool


def condition_key(settings: RunSettings) -> str:
    """What makes two runs repeats of each other: everything in the name but the stamp."""
    stamped = RunSettings(
        "", _ANY_STAMP, settings.travel, settings.speed, settings.preload, settings.voltage,
        settings.frequency, settings.width, settings.substrate,
    )  # fmt: skip
    return log_name(stamped)[len("20000101_00_00_00_bts_") :]


def slot_key(slot: Slot) -> str:
    """``condition_key`` of the slot's runs."""
    return condition_key(slot.settings(_ANY_STAMP))


def read_plan(path: Path) -> Plan:
    """The plan in a file. Raises InputError for an unknown key, a value beyond the rig's limits, no condition."""
    return make_plan(read_yaml(path), path)


def make_plan(document: Mapping[str, Any], where: object) -> Plan:
    """The plan that a document says; ``where`` names it in errors."""
    check(document, "plan", where)
    full = with_defaults(document, load_schema("plan"))
    rig = full["rig"]
    timing = Timing(rig["before_s"], rig["after_s"], 1.0 / rig["sample_rate_hz"])
    command = Command(full["travel_mm"] * 1e-3, full["speed_mm_s"] * 1e-3)
    conditions = _conditions(full)
    if not conditions:
        raise InputError(where, "has no condition", "add factors or conditions")
    _within_limits(conditions, full, command, timing, where)
    slots = _ordered(conditions, full["block_by"], np.random.default_rng(full["seed"]))
    return Plan(
        name=full["name"],
        slots=tuple(Slot(_setting(condition), command, repeat) for condition, repeat in slots),
        timing=timing,
        link=LinkSettings(rig["speed_factor"], rig["silence_margin_s"], rig["idle_s"], rig["reappear_s"]),
        grid=Grid(rig["force_step_n"], rig["voltage_step_v"]),
        voltage_tolerance=rig["voltage_tolerance"],
        retries=full["retries"],
        log_format=full["log_format"],
        count_existing=full["count_existing"],
    )


def _conditions(full: Mapping[str, Any]) -> list[dict[str, Any]]:
    """All conditions, each once: the crossing of the factors, then those listed (which may raise the repeats)."""
    found: dict[tuple[Any, ...], dict[str, Any]] = {}
    levels = {**{key: [level] for key, level in _DEFAULT_LEVELS.items()}, "substrate": [full["substrate"]]}
    listed: list[dict[str, Any]] = []
    if full.get("factors"):
        names = list(levels)
        crossed = itertools.product(*({**levels, **full["factors"]}[name] for name in names))
        listed += [dict(zip(names, combination, strict=True)) for combination in crossed]
    for condition in (*listed, *full["conditions"]):
        complete = {
            "preload_g": -1.0,
            "substrate": full["substrate"],
            "repeats": full["repeats"],
            **condition,
        }
        key = tuple(complete[name] for name in levels)
        before = found.get(key)
        if before is None or complete["repeats"] > before["repeats"]:
            found[key] = complete
    return list(found.values())


def _within_limits(
    conditions: Sequence[Mapping[str, Any]],
    full: Mapping[str, Any],
    command: Command,
    timing: Timing,
    where: object,
) -> None:
    rig = full["rig"]
    for condition in conditions:
        for key, limit in (("voltage_v", "voltage_max_v"), ("frequency_hz", "frequency_max_hz")):
            if condition[key] > rig[limit]:
                what = f"{condition[key]:g} is beyond the rig's {limit} of {rig[limit]:g}"
                raise InputError(f"{where}, {key}", what, "lower it")
    for key, limit in (("travel_mm", "travel_max_mm"), ("speed_mm_s", "speed_max_mm_s")):
        if full[key] > rig[limit]:
            raise InputError(
                f"{where}, {key}", f"{full[key]:g} is beyond the rig's {limit} of {rig[limit]:g}", "lower it"
            )
    command.encode()
    samples = command.samples(timing)
    if samples > rig["samples_max"]:
        duration = command.recording_duration(timing)
        what = f"a run of {duration:g} s has {samples} samples, the rig holds {rig['samples_max']}"
        raise InputError(f"{where}, travel_mm", what, "travel less far or faster")


def _ordered(
    conditions: Sequence[Mapping[str, Any]], block_by: Sequence[str], rng: np.random.Generator
) -> list[tuple[Mapping[str, Any], int]]:
    """Runs in random order within nested blocks of random order; repeats of a condition in rising order."""
    most = max(condition["repeats"] for condition in conditions)
    runs = [
        (condition, repeat)
        for repeat in range(most)
        for condition in conditions
        if repeat < condition["repeats"]
    ]
    shuffled = _shuffled(runs, list(block_by), rng)
    met: dict[int, int] = {}
    ordered = []
    for condition, _ in shuffled:
        repeat = met.get(id(condition), 0)
        met[id(condition)] = repeat + 1
        ordered.append((condition, repeat))
    return ordered


def _shuffled(runs: list, block_by: list[str], rng: np.random.Generator) -> list:
    if not block_by:
        return [runs[i] for i in rng.permutation(len(runs))]
    key, further = block_by[0], block_by[1:]
    blocks: dict[Any, list] = {}
    for condition, repeat in runs:
        blocks.setdefault(repeat if key == "repeat" else condition[key], []).append((condition, repeat))
    # repeats stay in time's order, so that one that is stopped has whole blocks
    order = range(len(blocks)) if key == "repeat" else rng.permutation(len(blocks))
    listed = list(blocks.values())
    return [run for i in order for run in _shuffled(listed[i], further, rng)]


def _setting(condition: Mapping[str, Any]) -> BenchSetting:
    grams = float(condition["preload_g"])
    return BenchSetting(
        voltage=float(condition["voltage_v"]),
        frequency=float(condition["frequency_hz"]),
        width=float(condition["width_mm"]) * 1e-3,
        substrate=condition["substrate"],
        preload=None if grams < 0 else grams * _GRAM,
    )
