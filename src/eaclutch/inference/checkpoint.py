"""Checkpoints of interrupted sampling: enough to go on bit for bit, and only where nothing has changed."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from eaclutch.files import atomic
from eaclutch.records import FloatArray, InputError

FORMAT = 1


@dataclass(frozen=True)
class Checkpoint:
    """Chains so far. chain (ensembles, steps, walkers, params) and log_density (ensembles, steps, walkers) in
    the priors' normal coordinates; random_states: one Mersenne state an ensemble; centres (ensembles, params) and
    roots (ensembles, params, params) of the jump targets; evaluations of the likelihood."""

    chain: FloatArray
    log_density: FloatArray
    random_states: tuple[tuple, ...]
    centres: FloatArray
    roots: FloatArray
    evaluations: int


def save(path: Path, checkpoint: Checkpoint, fingerprints: Mapping[str, str]) -> None:
    """Write atomically; arrays and JSON only."""
    states = checkpoint.random_states
    with atomic(path) as temporary, temporary.open("wb") as stream:
        np.savez(
            stream,
            format=np.array(FORMAT),
            fingerprints=np.array(json.dumps(dict(fingerprints), sort_keys=True)),
            chain=checkpoint.chain,
            log_density=checkpoint.log_density,
            centres=checkpoint.centres,
            roots=checkpoint.roots,
            keys=np.stack([state[1] for state in states]),
            positions=np.array([[state[2], state[3]] for state in states]),
            cached=np.array([state[4] for state in states]),
            evaluations=np.array(checkpoint.evaluations),
        )


def load(path: Path, fingerprints: Mapping[str, str]) -> Checkpoint:
    """Read back; raises InputError that says which of data, code, prior or parameter order has changed."""
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            if int(stored["format"]) != FORMAT:
                raise InputError(path, "is a checkpoint of another format", "delete it to start over")
            changed = _changed(json.loads(str(stored["fingerprints"])), fingerprints)
            if changed:
                what = f"cannot be resumed: {', '.join(changed)} changed since it was written"
                raise InputError(path, what, "delete it to start over, or undo the change")
            states = tuple(
                ("MT19937", key, int(position[0]), int(position[1]), float(cached))
                for key, position, cached in zip(
                    stored["keys"], stored["positions"], stored["cached"], strict=True
                )
            )
            return Checkpoint(
                stored["chain"], stored["log_density"], states, stored["centres"], stored["roots"],
                int(stored["evaluations"]),
            )  # fmt: skip
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(path, "is not a readable checkpoint", "delete it to start over") from error


def _changed(stored: Mapping[str, str], current: Mapping[str, str]) -> list[str]:
    return sorted(name for name in {*stored, *current} if stored.get(name) != current.get(name))
