"""What a run's prediction is uncertain by before any parameter is: the measured forces that it starts from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

from eaclutch.diagnosis.forward import Forward
from eaclutch.records import FloatArray, RunConditions

VERGE = 0.1  # of the force at switch-off: static friction scatters by several percent from run to run
LARGEST_CARRIED = 0.5  # sd on the comparison scale; a run that starts on an edge is not worth less than that
MEASURED = ("friction_before", "switch_off_force")


def carried(
    forward: Forward, table: pd.DataFrame, parameters: Mapping[str, float]
) -> tuple[FloatArray, FloatArray]:
    """Run-level predictions at ``parameters`` and the standard uncertainty that they have from the measured forces,
    (channels, runs) each, on the comparison scale.

    A run that was measured to slip where the model sticks, and would not with a little more force, says that it was on
    the verge, and nothing of its release. table: runs.csv's rows for exactly the runs of ``forward``.
    """
    conditions = forward.data.conditions
    named = {name: np.array([value]) for name, value in parameters.items()}

    def starting_from(moved: RunConditions) -> Forward:
        return Forward(forward.model, replace(forward.data, conditions=moved))

    plain = forward.runs(named)[0]
    beyond = starting_from(replace(conditions, switch_off_force=(1.0 + VERGE) * conditions.switch_off_force))
    verge = forward.unpredicted(named)[0] & ~beyond.unpredicted(named)[0]
    sd = np.where(verge, LARGEST_CARRIED, 0.0)
    for name in MEASURED:
        column = f"{name}_n_sd"
        if column not in table:
            continue
        own = np.nan_to_num(pd.to_numeric(table[column], errors="coerce").to_numpy(dtype=float))
        moved = starting_from(replace(conditions, **{name: getattr(conditions, name) + own}))
        sd = np.hypot(sd, moved.runs(named)[0] - plain)
    return plain, np.minimum(sd, LARGEST_CARRIED)
