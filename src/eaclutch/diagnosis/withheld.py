"""Base effects that a model was told to leave out: what a verdict has to say of each, named or not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from eaclutch.diagnosis.gaussian import Linearised
from eaclutch.diagnosis.localise import Explained
from eaclutch.diagnosis.result import CandidateResult
from eaclutch.diagnosis.study import Study
from eaclutch.physics.effects import BASE


def taken_over(shift: np.ndarray, fit: Linearised, noise: np.ndarray) -> float:
    """Share (0 to 1) of what an effect does, ``shift`` (entries,) in mean squares of the repeats' ``noise`` (entries,
    entries), that the calibrated parameters of the base model's ``fit`` can take over; 0 for one that does nothing."""
    explained = Explained.of(shift, fit.jacobian, noise)
    does = float(np.sum((explained.shift / explained.noise) ** 2))
    leaves = float(np.sum((explained.left / explained.noise) ** 2))
    return float(np.clip(1.0 - leaves / does, 0.0, 1.0)) if does > 0.0 else 0.0


def told_by(shift: np.ndarray, fit: Linearised) -> float:
    """Nats by which data are expected to speak for an effect that moves them by ``shift`` (entries,), against the base
    model's ``fit`` that lacks it, with what the fit leaves open in them: its parameters, noise, sessions, tolerance."""
    return 0.5 * float(shift @ np.linalg.solve(fit.marginal(), shift))


def withheld(study: Study, results: Sequence[CandidateResult], best: tuple[str, ...]) -> list[str]:
    """A caveat for each base effect that the model leaves out.

    Of one that the most probable set ``best`` does not hold: how much of what it does the calibrated parameters can
    take over, and how many nats the rest could tell it by. Of one that it holds: its strength, where the data bear
    surely less than its law says (1)."""
    noise = study.kernels.total(tolerance=0.0, session=0.0, scatter=False)
    fit, notes = study.base.linearised, []
    for result in results:
        if len(result.effects) != 1 or result.effects[0] not in BASE or result.effects[0] in best:
            continue
        name, shift = result.effects[0].replace("_", " "), np.array(result.shift)
        notes.append(
            f"{name} is left out of the model; of what it would do here the calibrated parameters can take over "
            f"{taken_over(shift, fit, noise):.0%}, and the rest could tell it by {told_by(shift, fit):.0f} nats beyond "
            "noise and what this model's laws may be off by"
        )
    strengths = {
        name: result.parameters.get("strength" if len(best) == 1 else f"{name}.strength")
        for result in results
        for name in best
        if result.effects == best and name in BASE
    }
    notes += [
        f"the data bear {found['mean']:.2f} +- {found['sd']:.2f} of what the law of {name.replace('_', ' ')} says"
        for name, found in strengths.items()
        # a switch has no strength in between, and one that moves nothing has none that was fitted
        if found and found["mean"] + study.thresholds["caveats"]["weak_law_sd"] * found["sd"] < 1.0
    ]
    return notes
