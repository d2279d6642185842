"""The capacitance bench: the gap at which contact and adhesion carry a given load."""

from __future__ import annotations

from eaclutch.physics.kernels.compiled import compiled
from eaclutch.physics.kernels.contact import adhesion
from eaclutch.physics.kernels.statics import LEAST_LOAD, gap_at_load


@compiled
def gaps_at_loads(rows, loads, tables, gaps):
    """Fill ``gaps`` (n,) [m] for ``rows`` (n,) and ``loads`` (n,) [N]."""
    for i in range(len(rows)):
        load = max(loads[i], LEAST_LOAD)
        gap = gap_at_load(rows[i], load, tables)
        if rows[i].adhesion_force != 0.0:
            for _ in range(60):
                pull, _ = adhesion(rows[i], gap, tables)
                gap += 0.7 * (gap_at_load(rows[i], load + pull, tables) - gap)
        gaps[i] = gap
