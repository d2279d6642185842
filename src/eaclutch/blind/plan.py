"""What is asked of the generator: one entry a case, drawn by seed; development and sealed never meet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from eaclutch.blind.candidates import NAMED
from eaclutch.blind.strangers import UNNAMED

Kind = Literal["none", "single", "unknown", "pair"]
NAMESPACES = {"dev": 0x0DE7, "sealed": 0x5EA1, "test": 0x7E57}
SIZE_RANGE = (0.15, 3.0)  # of the magnitudes in the literature, log-uniform, where no limit is given
LIMIT_RANGE = (2.0, 4.0)  # times the forecast detection limit


@dataclass(frozen=True)
class Entry:
    """One case to make. ``effects``: (name, size in the generator's own magnitudes), in no order that tells.

    ``misfit``: share of another contact law that is mixed in beside the effect.
    """

    case: str
    namespace: str
    seed: int
    kind: Kind
    effects: tuple[tuple[str, float], ...]
    misfit: float = 0.0
    misfit_law: str = "exponential"


def generator(namespace: str, seed: int, purpose: str) -> np.random.Generator:
    """The stream of one purpose of one case. The namespace is a word of the seed, so streams never coincide."""
    words = [NAMESPACES[namespace], seed, *purpose.encode()]
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(words)))


def draw_size(name: str, limits: dict[str, float] | None, rng: np.random.Generator) -> float:
    """Size of an effect: 2-4 times its forecast limit where one is given, else from far below to far above 1."""
    if limits and name in limits:
        return float(limits[name] * rng.uniform(*LIMIT_RANGE))
    return float(np.exp(rng.uniform(*np.log(SIZE_RANGE))))


def make_plan(
    namespace: str,
    seed: int,
    *,
    none: int,
    unknown: int,
    each_single: int = 0,
    singles: int = 0,
    pairs: int,
    limits: dict[str, float] | None = None,
    misfit_share: float = 0.1,
    prefix: str | None = None,
) -> tuple[Entry, ...]:
    """Entries in random order: ``none`` without effect, ``unknown`` with one the library lacks, ``each_single``
    of every named effect and ``singles`` more spread evenly over them, ``pairs`` of two named ones.

    ``limits``: size by effect that the frozen forecast calls just detectable. ``misfit_share`` of the cases
    with an effect carry a mild misfit of the contact law beside it. Cases are named ``<prefix>-0000`` ..;
    the default prefix holds the seed, so a sealed plan must state its own.
    """
    rng = generator(namespace, seed, "plan")
    named, strangers = list(NAMED), list(UNNAMED)
    drafts: list[tuple[Kind, tuple[str, ...]]] = [("none", ())] * none
    offset = int(rng.integers(0, len(strangers)))
    drafts += [("unknown", (strangers[(i + offset) % len(strangers)],)) for i in range(unknown)]
    drafts += [("single", (name,)) for name in named for _ in range(each_single)]
    order = rng.permutation(len(named))
    drafts += [("single", (named[order[i % len(named)]],)) for i in range(singles)]
    for _ in range(pairs):
        a, b = rng.choice(len(named), size=2, replace=False)
        drafts.append(("pair", (named[a], named[b])))
    entries = []
    for place, index in enumerate(rng.permutation(len(drafts))):
        kind, names = drafts[index]
        effects = tuple((name, draw_size(name, limits, rng)) for name in names)
        bent = kind in ("single", "pair") and rng.random() < misfit_share
        entries.append(
            Entry(
                case=f"{prefix or f'{namespace}-{seed}'}-{place:04d}",
                namespace=namespace,
                seed=int(rng.integers(0, 2**62)),
                kind=kind,
                effects=effects,
                misfit=float(rng.uniform(0.1, 0.3)) if bent else 0.0,
                misfit_law=str(rng.choice(["exponential", "fractal"])),
            )
        )
    return tuple(entries)
