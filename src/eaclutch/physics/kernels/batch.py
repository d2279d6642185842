"""Batches of simulations in parallel: one ``Row`` in, one line of results out."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from eaclutch.physics.kernels.compiled import compiled, compiled_free, threads, unmanaged
from eaclutch.physics.kernels.engagement import engagement_time
from eaclutch.physics.kernels.parting import release
from eaclutch.physics.kernels.ramp import climb_since_level, driven_run, force_after_hold
from eaclutch.physics.kernels.readout import read_crossings
from eaclutch.physics.kernels.release import final_force
from eaclutch.physics.kernels.statics import (
    NEVER_SLIPS,
    OK,
    PULL_IN,
    TIMED_OUT,
    driven_gap,
    held_gap,
    rest_before,
)
from eaclutch.physics.kernels.tip import COLUMNS, SEGMENTS
from eaclutch.physics.tables import Tables

# Columns of the results.
RESULTS = (
    "preload", "gap_before", "gap_driven", "capacity", "switch_off", "slip_fraction", "ramp", "ramp_early",
    "ramp_late", "engagement", "release_10", "release_50", "release_90", "final",
    "own_switch_off", "gap_held",
)  # fmt: skip
STATUSES = ("capacity", "engagement", "release")
WORTH_SHARING = 20_000.0  # us of work


@compiled
def bare_tables(tables):
    """The tables without reference counts."""
    return Tables(unmanaged(tables.contact), unmanaged(tables.roughness), unmanaged(tables.relaxation))


@compiled
def steady(p, tables, out, status):
    """Fill the results that need no time stepping; True if there is an equilibrium with voltage."""
    preload, gap_before = rest_before(p, tables)
    out[0], out[1] = preload, gap_before
    kind, gap = driven_gap(p, preload, gap_before, tables)
    out[2] = gap
    if kind == PULL_IN:
        status[:] = PULL_IN
        return False
    status[0], out[3], out[4], out[5], out[6], out[7], out[8], out[14] = driven_run(
        p, gap, gap_before, tables
    )
    out[15] = gap
    if p.held_factor != 1.0:
        kind, out[15] = held_gap(p, preload, gap_before, tables)
        if kind == PULL_IN:
            status[:] = PULL_IN
            return False
        out[14] = force_after_hold(p, out[14], out[15], gap_before, tables)
        if math.isnan(p.switch_off_force):
            out[4] = out[14]
    return True


@compiled
def simulate(p, tables, engage, releasing, fraction, tolerance, segments, work, out, status):
    """One simulation; ``engage``, ``releasing`` say which of the two dynamic parts is wanted."""
    out[:] = math.nan
    status[:] = OK
    if not steady(p, tables, out, status):
        return 0
    if engage:
        if p.voltage == 0.0:
            status[1] = TIMED_OUT
        else:
            status[1], time = engagement_time(p, out[0], out[1], out[2], fraction, tolerance, tables)
            if status[1] == OK:
                out[9] = time + p.drive_delay
    # as the rig reads it, a force at switch-off is the level of the last 3 ms
    climb = climb_since_level(p)
    out[14] -= climb
    if math.isnan(p.switch_off_force):
        out[4] -= climb
    if not releasing:
        return 0
    start = out[4] + climb
    kind, n, rest_time, rest_force = release(
        p, out[0], out[1], out[15], start, tolerance, tables, segments, work
    )
    status[2] = kind
    final = final_force(segments, n, rest_time, rest_force, start) if kind != TIMED_OUT else math.nan
    out[13] = final
    if kind != OK:
        return n
    way = out[4] - final
    if way <= 0.0:
        status[2] = NEVER_SLIPS
        return n
    levels = work[0]
    levels[0], levels[1], levels[2] = out[4] - 0.1 * way, out[4] - 0.5 * way, out[4] - 0.9 * way
    read_crossings(p, segments, n, start, levels[:3], out[10:13])
    out[10:13] += p.drive_delay
    if math.isnan(out[12]):
        status[2] = TIMED_OUT
    return n


@compiled_free
def _simulate_share(
    rows, first, stride, tables, engage, releasing, fraction, tolerance, kept, scratch, out, statuses
):
    segments, work, light = unmanaged(kept), unmanaged(scratch), bare_tables(tables)
    for i in range(first, len(rows), stride):
        simulate(rows[i], light, engage, releasing, fraction, tolerance, segments, work, out[i], statuses[i])


def simulate_share(rows, first, stride, tables, engage, releasing, fraction, tolerance, out, statuses):
    """Every ``stride``-th simulation from ``first`` on."""
    # made and held here: compiled code lets go of an array after its last use, which for ``unmanaged`` is too early
    kept, scratch = np.empty((SEGMENTS, COLUMNS)), np.empty((4, 6))
    _simulate_share(
        rows, first, stride, tables, engage, releasing, fraction, tolerance, kept, scratch, out, statuses
    )


def simulate_batch(rows, tables, engage, releasing, fraction, tolerance, out, statuses):
    """``rows`` (n,) of Row -> ``out`` (n, results), ``statuses`` (n, 3), in interleaved shares, one a thread.
    Small batches stay in one: handing them out costs more than they do, the more so where other processes keep the
    cores busy. Plain threads, and not the compiler's own: those need everything compiled a second time, and do not
    live on in a forked process."""
    small = len(rows) * (1.0 + 5.0 * engage + 20.0 * releasing) < WORTH_SHARING
    shares = 1 if small else threads()

    def work(share):
        simulate_share(rows, share, shares, tables, engage, releasing, fraction, tolerance, out, statuses)

    if shares == 1:
        work(0)
        return
    with ThreadPoolExecutor(shares) as pool:
        list(pool.map(work, range(shares)))


@compiled
def trace(p, tables, tolerance, segments, work):
    """(status, segments used, force at switch-off, force at rest) of one release, for its history; the row's force at
    switch-off is the one at that instant."""
    out, status = np.empty(len(RESULTS)), np.empty(3, dtype=np.int64)
    out[:] = math.nan
    if not steady(p, tables, out, status):
        return PULL_IN, 0, math.nan, math.nan
    kind, n, _, rest = release(p, out[0], out[1], out[15], out[4], tolerance, tables, segments, work)
    return kind, n, out[4], rest
