"""Where the run stands when the voltage falls, and how the force creeps while the stage rests."""

from __future__ import annotations

import math
from dataclasses import replace

from eaclutch.records import ObservableInfo
from eaclutch.rig.estimate import Estimate, Unusable
from eaclutch.rig.observables._observable import Observable
from eaclutch.rig.observables.capacity import peak
from eaclutch.rig.observables.ramp import slope
from eaclutch.rig.observables.slip import slips_between
from eaclutch.rig.run_view import RunView

CREEP_WINDOW = 0.3  # s before the voltage falls
STAGE_SETTLING = 0.02  # s after the stage stopped
SHORTEST_CREEP = 0.1  # s


def _switch_off(run: RunView) -> Estimate:
    level = run.switch_off_level
    return Estimate(level.value - run.zero.value, math.hypot(level.sd, run.zero.sd))


def _start_ratio(run: RunView) -> Estimate:
    """(S - E) / (P - b + B - E): S, E, P, b, B = force at switch-off, at the end, at the peak, just before and
    0.5 s before the voltage. The zero cancels."""
    level, final, top = run.switch_off_level, run.final_level, peak(run)
    before = run.force_before_on
    friction = run.friction_level
    way = level.value - final.value
    most = top.value - before.value + friction.value - final.value
    if most < 5.0 * math.hypot(top.sd, before.sd, final.sd):
        raise Unusable("no_capacity")
    ratio = way / most
    # what the drive's edges add, level and peak have in common
    common = run.drive_offset_sd
    own_level, own_top = (math.sqrt(max(part.sd**2 - common**2, 0.0)) for part in (level, top))
    parts = (
        own_level,
        ratio * math.hypot(own_top, before.sd, friction.sd),
        (1.0 - ratio) * math.hypot(final.sd, common),
    )
    return Estimate(ratio, math.hypot(*parts) / most)


def _creep(run: RunView) -> Estimate:
    run.require_unbroken_hold()
    off = run.events.off - run.off_doubt  # the release is no creep
    start = max(off - CREEP_WINDOW, run.events.stage_stop + STAGE_SETTLING)
    if off - start < SHORTEST_CREEP:
        raise Unusable("stage_moves_until_off")
    creep = slope(run, start, off)
    return replace(creep, flag="slips_at_rest") if slips_between(run, start, off) else creep


OBSERVABLES = (
    Observable(
        ObservableInfo(
            "switch_off_force_n",
            "N",
            "hold",
            "median force of the last 3 ms before voltage off, less the zero",
        ),
        _switch_off,
    ),
    Observable(
        ObservableInfo(
            "start_ratio",
            "1",
            "hold",
            "(switch_off_force - final) / (shear_capacity + friction_before - final)",
        ),
        _start_ratio,
    ),
    Observable(
        ObservableInfo(
            "hold_creep_n_s",
            "N/s",
            "hold",
            "slope of the force over the last 0.3 s before voltage off where the stage rests",
        ),
        _creep,
    ),
)
