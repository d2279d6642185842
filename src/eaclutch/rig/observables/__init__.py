"""Observables: one file a quantity (or a tightly related family), found by listing this folder.

Each module defines ``OBSERVABLES``, a tuple of ``Observable``. ``measure`` takes the run and returns value and
standard uncertainty, or raises ``Unusable`` with the reason.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping

from eaclutch.rig.observables._observable import PHASES, Observable

__all__ = ["OBSERVABLES", "PHASES", "Observable"]


def _find() -> Mapping[str, Observable]:
    found: list[Observable] = []
    for module in pkgutil.iter_modules(__path__):
        if not module.name.startswith("_"):
            found += importlib.import_module(f"{__name__}.{module.name}").OBSERVABLES
    found.sort(key=lambda item: PHASES.index(item.info.phase))
    names = [item.info.name for item in found]
    if len(set(names)) != len(names):
        raise ImportError("two observables share a name")
    return dict(zip(names, found, strict=True))


OBSERVABLES: Mapping[str, Observable] = _find()
