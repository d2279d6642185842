"""A release whose faces part with another pull than they met with: adhesion hysteresis around the fall itself."""

from __future__ import annotations

from eaclutch.physics.kernels.compiled import compiled
from eaclutch.physics.kernels.drive import RELEASING
from eaclutch.physics.kernels.film import equilibrium
from eaclutch.physics.kernels.release import END, fall


@compiled
def release(p, preload, gap_before, gap_driven, switch_off, tolerance, tables, segments, work):
    """(status, segments used, time of rest, force at rest [N]) from the force ``switch_off`` [N] at t = 0, the faces
    attracting each other ``adhesion_separating`` times as much as before it."""
    meeting, gap_after = p.adhesion_force, gap_before
    if p.adhesion_separating != 1.0 and meeting != 0.0:
        p.adhesion_force = meeting * p.adhesion_separating
        gap_after, _ = equilibrium(p, END, gap_before, preload + p.film_weight, gap_before, RELEASING, tables)
    found = fall(p, preload, gap_before, gap_after, gap_driven, switch_off, tolerance, tables, segments, work)
    p.adhesion_force = meeting
    return found
