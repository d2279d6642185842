"""Base effects that a model was told to leave out: they act on every clutch, whatever a verdict says of them."""

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


def withheld(study: Study, results: Sequence[CandidateResult], best: tuple[str, ...]) -> list[str]:
    """A caveat for each base effect that the model leaves out and the most probable set ``best`` does not hold: how
    much of what it does the calibrated parameters can take over. A name can rest on the remaining part only."""
    noise = study.kernels.total(tolerance=0.0, session=0.0, scatter=False)
    return [
        f"{name.replace('_', ' ')} is left out of the model, and of what it would do here the calibrated parameters "
        f"can take over {taken_over(np.array(result.shift), study.base.linearised, noise):.0%}"
        for name in study.candidates
        if name in BASE and name not in best
        for result in results
        if result.effects == (name,)
    ]
