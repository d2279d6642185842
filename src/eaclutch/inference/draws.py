"""Joint draws of all parameters from the stages' files, for the force stage and for prediction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from eaclutch.inference import storage
from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import STAGES
from eaclutch.physics.effect import STRENGTH, Parameter
from eaclutch.physics.effects import EFFECTS
from eaclutch.records import FloatArray, InputError

PER_RUN = ("slip_phase",)  # drawn anew for every run where a prediction needs it


def load_draws(paths: Sequence[Path], draws: int) -> dict[str, FloatArray]:
    """Joint draws {name: (draws,)} of the stages' files (any order; the stage stands in the file).

    The force file holds the other stages' parameters as its capacities moved them, so where it was fitted to
    data its draws win; otherwise the stages are independent. Spreads and noises are left out.
    Raises InputError for a file that is none, or a stage given twice.
    """
    stored: dict[str, storage.StoredPosterior] = {}
    for path in paths:
        found = storage.load(Path(path))
        stage = str(found.attributes["stage"])
        if stage in stored:
            raise InputError(path, f"is a second file of the stage {stage}", "give one file a stage")
        stored[stage] = found
    joint: dict[str, FloatArray] = {}
    for order, stage in enumerate(s for s in STAGES if s in stored):
        joint |= spread_out(stored[stage].draws, draws, order)
    return {name: values for name, values in joint.items() if name not in HYPERPARAMETERS}


def spread_out(values: Mapping[str, FloatArray], draws: int, order: int) -> dict[str, FloatArray]:
    """``draws`` rows of a stage's draws: evenly spaced, in an order of the stage's own (the stages shall not pair
    up by position); the same rows for all of its variables."""
    size = len(next(iter(values.values())))
    rows = np.random.default_rng([12345, order]).permutation(size)
    rows = rows[np.linspace(0, size - 1, draws).round().astype(int)]
    return {name: np.asarray(array)[rows] for name, array in values.items()}


def other_parameters(known: Mapping[str, Parameter], have: Sequence[str]) -> list[Parameter]:
    """Model parameters that no stage has calibrated: friction, those of candidate effects that are on, and what a base
    effect leaves open (how much a drive loses at reversals).

    The multiplier, per-run parameters and strengths of base effects are not among them.
    """
    chosen = []
    for name, parameter in known.items():
        if name in have or name in PER_RUN or name.startswith("force_multiplier"):
            continue
        effect, _, own = name.rpartition(".")
        if own == STRENGTH.name and EFFECTS[effect].role == "base":
            continue
        chosen.append(parameter)
    return chosen


def with_prior_draws(
    joint: Mapping[str, FloatArray], known: Mapping[str, Parameter], draws: int, rng: np.random.Generator
) -> dict[str, FloatArray]:
    """``joint`` completed by prior draws of what no stage has calibrated, and kept inside the bounds."""
    rest = other_parameters(known, list(joint))
    complete = dict(joint)
    if rest:
        values = Priors.of(rest).sample(rng, draws)
        complete |= {parameter.name: values[:, i] for i, parameter in enumerate(rest)}
    return inside(complete, known)


def inside(joint: Mapping[str, FloatArray], known: Mapping[str, Parameter]) -> dict[str, FloatArray]:
    """``joint`` with each parameter kept inside its bounds: draws that capacities moved may leave them."""
    return {
        name: np.clip(values, *known[name].bounds) if name in known else values
        for name, values in joint.items()
    }
