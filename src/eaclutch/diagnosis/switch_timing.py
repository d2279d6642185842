"""Where between two samples the voltage fell: what runs of one drive frequency may share.

A log places voltage off in the middle of two samples, and it may have been anywhere between (``EDGE_SD``). Repeats
average that out only where the switch runs free of the sampling. Where drives last the same number of samples run after
run, both may hang on one clock, and then a whole frequency is early or late together: 20 us between drive frequencies
look like a charge that slow drives leave behind.
"""

from __future__ import annotations

import numpy as np

from eaclutch.records import FloatArray, RunConditions

SAMPLE = 1.0 / 12_800.0  # s
EDGE_SD = SAMPLE / np.sqrt(12.0)
POOLED = (
    10.0  # odd counts expected of a free switch, that the whole campaign weighs beside those of one frequency
)
FREE = 0.5  # of the odd counts expected, from which on a campaign's switch runs free: their number scatters by a third


def shared_edge_sd(conditions: RunConditions) -> FloatArray:
    """Standard uncertainty [s] (runs,) of voltage off that the runs of a drive frequency share.

    From how many runs last another number of samples than most of their frequency do, over how many would if the switch
    ran free: none: they share all of it.
    """
    odd, expected = np.zeros(len(conditions)), np.zeros(len(conditions))
    levels, index = np.unique(conditions.frequency, return_inverse=True)
    for level in range(len(levels)):
        rows = index == level
        duration = conditions.drive_duration[rows]
        odd[rows] = np.count_nonzero(np.abs(duration - np.median(duration)) > 0.5 * SAMPLE)
        expected[rows] = expected_odd(int(np.count_nonzero(rows)))
    first = np.unique(index, return_index=True)[1]
    of_all = min(1.0, float(odd[first].sum()) / max(FREE * float(expected[first].sum()), 1e-9))
    free = (odd + POOLED * of_all) / (expected + POOLED)
    return EDGE_SD * np.sqrt(np.clip(1.0 - free, 0.0, 1.0))


def expected_odd(runs: int) -> float:
    """How many of ``runs`` last a sample more or less than most, where a drive of any length meets free sampling: the
    share with the longer count is uniform, so each split of the runs is equally probable."""
    split = np.arange(runs + 1)
    return float(np.minimum(split, runs - split).mean())
