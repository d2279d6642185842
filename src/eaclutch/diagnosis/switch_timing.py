"""Where between two samples the voltage fell, and how its fall is read: what runs share.

A log places voltage off in the middle of two samples, and it may have been anywhere between (``EDGE_SD``). Repeats
average that out only where the switch runs free of the sampling. Where drives last the same number of samples run after
run, both may hang on one clock, and then a whole frequency is early or late together: 20 us between drive frequencies
look like a charge that slow drives leave behind. And where a log leaves open whether the drive finished its half wave
(voltage_off_unsure), it does so in most runs of a frequency, with the same answer.

The first samples of a fall lie under the drive's pick-up: what is put in their place (``rig.fall``) suits no fall
exactly, and falls of one bench are alike (``FALL_SD``).
"""

from __future__ import annotations

import numpy as np

from eaclutch.records import FloatArray, RunConditions
from eaclutch.simulation.observables import EDGE_SD

SAMPLE = EDGE_SD * np.sqrt(12.0)  # s
# By what the release times of all runs may be off together [s]. Simulated fast load cells with narrow strips are read
# right to 3 us (benchmarks/extractor_coverage.py, fast), those of an outside generator 10 to 20 us late (by hand).
# Twice this cost two open trapped charges a fifth of their probability (by hand).
FALL_SD = 5.0e-6
# Odd counts expected of a free switch, that the whole campaign weighs beside those of one frequency.
POOLED = 10.0
# Of the odd counts expected, from which on a campaign's switch runs free: their number scatters by a third.
FREE = 0.5


def shared_edge_sd(conditions: RunConditions, doubt: FloatArray) -> FloatArray:
    """Standard uncertainty [s] (runs,) of voltage off that the runs of a drive frequency share.

    doubt: (runs,) [s], of a run's own voltage off where the log leaves open which it was, 0 where it is known to a
    sample, NaN for a run without release times; what more than half of a frequency's others have, they share.

    From how many runs last another number of samples than most of their frequency do, over how many would if the switch
    ran free: none: they share it, and the mean of n runs is as uncertain as one. What each run has by itself already
    counts among its noise, a share of 1 / n of the mean's variance; a frequency with one run shares nothing.
    """
    odd, expected, runs, unsure = (np.zeros(len(conditions)) for _ in range(4))
    levels, index = np.unique(conditions.frequency, return_inverse=True)
    for level in range(len(levels)):
        rows = index == level
        duration = conditions.drive_duration[rows]
        odd[rows] = np.count_nonzero(np.abs(duration - np.median(duration)) > 0.5 * SAMPLE)
        runs[rows] = np.count_nonzero(rows)
        expected[rows] = expected_odd(len(duration))
        timed = doubt[rows][np.isfinite(doubt[rows])]
        unsure[rows] = np.median(timed) if len(timed) else 0.0
    first = np.unique(index, return_index=True)[1]
    of_all = min(1.0, float(odd[first].sum()) / max(FREE * float(expected[first].sum()), 1e-9))
    free = (odd + POOLED * of_all) / (expected + POOLED)
    known = EDGE_SD**2 * np.clip(1.0 - free, 0.0, 1.0)
    shared: FloatArray = np.sqrt((known + unsure**2) * (1.0 - 1.0 / runs))
    return shared


def expected_odd(runs: int) -> float:
    """How many of ``runs`` last a sample more or less than most, where a drive of any length meets free sampling: the
    share with the longer count is uniform, so each split of the runs is equally probable."""
    split = np.arange(runs + 1)
    return float(np.minimum(split, runs - split).mean())
