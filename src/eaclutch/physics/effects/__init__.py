"""One file an effect; the list of effects is the folder. Each module defines ``EFFECT``."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping

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
