"""From a checked recipe to what ``simulate_campaign`` needs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from typing import Any

import numpy as np

from eaclutch.physics.effects import BASE, CANDIDATES, EFFECTS
from eaclutch.records import InputError
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.plan import Plan, RecordTiming, SideBenches, sweep


@dataclass(frozen=True)
class Recipe:
    """A campaign to simulate: plan, effects that are on, true parameters that depart from defaults, noise."""

    plan: Plan
    effects: tuple[str, ...]
    parameters: Mapping[str, float]
    noise: BenchNoise


def from_facts(facts: Mapping[str, Any], rng: np.random.Generator) -> Recipe:
    """The recipe from the facts of its file (checked, completed; units of the file).

    A candidate's parameters that the recipe leaves out are drawn. Raises InputError for names that no effect,
    parameter or noise figure has.
    """
    effects, parameters = _effects(facts, rng)
    days = [_day(text) for text in facts["sessions"]]
    for number, condition in enumerate(facts["conditions"]):
        if max(condition.get("sessions", [0])) >= len(days):
            raise InputError(
                f"recipe, conditions.{number}.sessions",
                f"there are {len(days)} sessions",
                "count them from 0",
            )
    record, side = facts["record"], facts["side"]
    plan = Plan(
        runs=sweep(facts["conditions"], days, facts["repeats"], rng),
        timing=RecordTiming(
            record["before_s"],
            record["travel_mm"] * 1e-3,
            record["after_s"],
            contact=tuple(record["contact_s"]),
        ),
        side=SideBenches(
            capacitance_widths=tuple(width * 1e-3 for width in side["capacitance_widths_mm"]),
            capacitance_trials=side["capacitance_trials"],
            permittivity_sources=side["permittivity_sources"],
            load_cell_logs=side["load_cell_logs"],
        ),
        extension=record["extension"],
        faults=facts["faults"],
    )
    return Recipe(plan, effects, {**facts["parameters"], **parameters}, _noise(facts["noise"]))


def _effects(facts: Mapping[str, Any], rng: np.random.Generator) -> tuple[tuple[str, ...], dict[str, float]]:
    parameters: dict[str, float] = {}
    for name, given in facts["effects"].items():
        if name not in CANDIDATES:
            raise InputError(
                f"recipe, effects.{name}", "is no candidate", f"use one of {', '.join(CANDIDATES)}"
            )
        values = EFFECTS[name].draw(rng) | given
        unknown = sorted(set(given) - {p.name for p in EFFECTS[name].parameters})
        if unknown:
            raise InputError(
                f"recipe, effects.{name}.{unknown[0]}", "is no parameter of it", "see eaclutch effects"
            )
        parameters |= {f"{name}.{key}": float(value) for key, value in values.items()}
    for name in facts["without"]:
        if name not in BASE:
            raise InputError(f"recipe, without: {name}", "is no base effect", f"use one of {', '.join(BASE)}")
    base = tuple(name for name in BASE if name not in facts["without"])
    return (*base, *facts["effects"]), parameters


def _noise(given: Mapping[str, float]) -> BenchNoise:
    scalars = {f.name for f in dataclasses.fields(BenchNoise) if f.type in ("float", "int")}
    unknown = sorted(set(given) - scalars)
    if unknown:
        raise InputError(
            f"recipe, noise.{unknown[0]}", "is no figure of the noise", f"use {', '.join(sorted(scalars))}"
        )
    try:
        return BenchNoise(**given)  # type: ignore[arg-type]
    except ValueError as error:
        raise InputError("recipe, noise", str(error), "give a number that is not negative") from None


def _day(text: str) -> date:
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise InputError(f"recipe, sessions: {text}", "is no date", "write YYYY-MM-DD") from None
