"""What runs of one drive frequency share of where, between two samples, the voltage fell."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis.screening import voltage_off_doubt
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.diagnosis.switch_timing import EDGE_SD, SAMPLE, expected_odd, shared_edge_sd

TIMES = ("release_time_10_s", "release_time_50_s", "release_time_90_s")


def of_durations(study, durations, doubt=0.0):
    conditions = replace(study.conditions, drive_duration=np.asarray(durations, dtype=float))
    return shared_edge_sd(conditions, np.full(len(conditions), doubt) if np.isscalar(doubt) else doubt)


@pytest.fixture(scope="module")
def study():
    return Study(inputs(), load_thresholds(), seed=3)


def test_a_free_switch_splits_the_counts_as_expected():
    rng = np.random.default_rng(2)
    for runs in (2, 3, 6, 20):
        share = rng.random(20_000)
        longer = rng.binomial(runs, share)
        assert np.minimum(longer, runs - longer).mean() == pytest.approx(expected_odd(runs), rel=0.03)
    assert expected_odd(1) == 0.0


def test_a_switch_in_step_with_the_sampling_shares_all_of_its_error(study):
    frequency = study.conditions.frequency
    shared = of_durations(study, 3.0 + 0.5 / frequency)
    _, index, runs = np.unique(frequency, return_inverse=True, return_counts=True)
    # with each run's own part the mean of a frequency is as uncertain as one run
    assert shared**2 + EDGE_SD**2 / runs[index] == pytest.approx(np.full(len(frequency), EDGE_SD**2))


def test_a_frequency_with_one_run_shares_nothing(study):
    alone = study.conditions.select(np.unique(study.conditions.frequency, return_index=True)[1])
    assert not shared_edge_sd(alone, np.full(len(alone), 6e-5)).any()


def test_what_the_log_leaves_open_is_shared_by_a_frequency(study):
    """Drives that last the same leave the same wave unseen: the mean of all their runs is as uncertain as one."""
    frequency = study.conditions.frequency
    known, unsure = (of_durations(study, 3.0 + 0.5 / frequency, doubt) for doubt in (0.0, 6e-5))
    _, index, runs = np.unique(frequency, return_inverse=True, return_counts=True)
    assert unsure**2 - known**2 == pytest.approx(3.6e-9 * (1.0 - 1.0 / runs[index]))
    one = np.arange(len(frequency)) % 3 > 0  # two of three runs show no time at all
    some = of_durations(study, 3.0 + 0.5 / frequency, np.where(one, np.nan, 6e-5))
    assert some == pytest.approx(np.where(np.isin(index, index[~one]), unsure, known))


def test_the_doubt_is_read_from_the_table(study):
    table = study.inputs.table.copy()
    table["flags"] = ""
    table.loc[table.index[3], "flags"] = "no_zero;voltage_off_unsure"
    doubt = voltage_off_doubt(table)
    assert np.flatnonzero(doubt > 0.0).tolist() == [3]
    assert doubt[3] == table["release_time_50_s_sd"].iloc[3]


def test_all_release_times_may_be_read_late_together(study):
    """A fall's first samples are put in by one rule for all runs."""
    data = study.data
    timed = np.char.startswith(data.channel.astype(str), "release_time")
    assert (data.fall_sd[timed] > 0.0).all() and not data.fall_sd[~timed].any()
    first = int(np.flatnonzero(timed)[0])
    # of another drive frequency, which shares nothing else
    other = int(np.flatnonzero(timed & (data.frequency != data.frequency[first]))[0])
    shared = study.kernels.shared_noise[first, other]
    assert shared == pytest.approx(data.fall_sd[first] * data.fall_sd[other]) and shared > 0.0


def test_a_free_switch_shares_little(study):
    rng = np.random.default_rng(4)
    frequency = study.conditions.frequency
    shares = []
    for _ in range(200):
        true = (
            3.0 + 0.5 / frequency + (rng.random(8) * SAMPLE)[np.unique(frequency, return_inverse=True)[1] % 8]
        )
        logged = np.floor(true / SAMPLE + rng.random(len(frequency))) * SAMPLE
        shares.append(np.mean((of_durations(study, logged) / EDGE_SD) ** 2))
    assert np.mean(shares) < 0.15


def test_a_late_frequency_is_no_gap_where_the_switch_keeps_step():
    """Release times of one frequency half a sample late: dear only where the switch runs free of the sampling."""
    given = inputs()
    in_step = given.table.assign(drive_duration_s=3.0 + 0.5 / given.table["frequency_hz"])
    free = in_step.assign(
        drive_duration_s=in_step["drive_duration_s"] + SAMPLE * (np.arange(len(in_step)) % 2)
    )
    late = given.table["frequency_hz"] == given.table["frequency_hz"].max()
    assert 0 < np.count_nonzero(late) < len(late)

    def lost(table):
        moved = table.copy()
        for name in TIMES:
            moved.loc[late, name] += 50e-6
        calm, shifted = (
            Study(replace(given, table=t), load_thresholds(), seed=3).weigh(()).log_evidence
            for t in (table, moved)
        )
        return calm - shifted

    assert lost(free) > lost(in_step) + 2.0
