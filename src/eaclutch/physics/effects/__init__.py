"""One file an effect; the list of effects is the folder. Each module defines ``EFFECT``."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from typing import Any

from eaclutch.physics.effect import Effect

# Effects fill sockets in the order of the stages: a later stage may see what an earlier one has set.
STAGES = (
    "session", "drive", "dielectric", "electrostatics", "contact", "film", "friction", "load_train",
    "readout", "capacitance_bench",
)  # fmt: skip


def _find() -> Mapping[str, Effect]:
    found = {}
    for module in pkgutil.iter_modules(__path__):
        effect: Effect = importlib.import_module(f"{__name__}.{module.name}").EFFECT
        if effect.name != module.name:
            raise ImportError(f"{module.name}.py defines the effect {effect.name}")
        found[effect.name] = effect
    return dict(sorted(found.items(), key=lambda item: (STAGES.index(item[1].stage), item[0])))


EFFECTS: Mapping[str, Effect] = _find()
BASE: tuple[str, ...] = tuple(name for name, effect in EFFECTS.items() if effect.role == "base")
CANDIDATES: tuple[str, ...] = tuple(name for name, effect in EFFECTS.items() if effect.role == "candidate")
LOOKALIKES: tuple[str, ...] = tuple(name for name, effect in EFFECTS.items() if effect.role == "lookalike")
NAMED: tuple[str, ...] = tuple(name for name in EFFECTS if name not in LOOKALIKES)  # what a diagnosis may say


def switched_on(model: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the effects that the config's ``model`` section switches on: those of the base model where its
    ``effects`` is null or missing, less ``without``."""
    chosen = model.get("effects")
    return tuple(
        name for name in (BASE if chosen is None else chosen) if name not in (model.get("without") or ())
    )
