"""The data vector: every usable observable averaged over (condition, session), plus the bench channels.

An *entry* is one mean: of a channel over the repeats of a condition in a session, or of a bench channel
(capacitance, permittivity, bursts of the load cell) at one setting. ``diagnosis.entries`` collects them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse

from eaclutch.diagnosis.bench_channels import BenchEntries
from eaclutch.diagnosis.channels import Channel
from eaclutch.records import FloatArray, RunConditions


@dataclass(frozen=True)
class DataVector:
    """What the hypotheses compete to explain; arrays are (entries,) unless stated.

    values, noise_sd: on the comparison scale. block, channel, condition, session: names (condition and
    session empty for bench entries). offset: label of the random offset an entry shares with others of its
    block (session, width, source); offset_sd: of what it shares beyond sessions' spread. features (entries,
    features): scaled settings for smooth terms; entries of different ``family`` (run, capacitance, ...) never share a
    smooth term.
    average: sparse (run entries, channels x runs) matrix that turns run-level predictions into entries.
    """

    conditions: RunConditions
    channels: tuple[Channel, ...]
    values: FloatArray
    noise_sd: FloatArray
    count: FloatArray
    block: np.ndarray
    channel: np.ndarray
    condition: np.ndarray
    session: np.ndarray
    offset: np.ndarray
    offset_sd: FloatArray
    edge_sd: FloatArray  # of voltage off, shared with other entries of the drive frequency (diagnosis.switch_timing)
    fall_sd: FloatArray  # of how a fall is read, shared by all entries
    frequency: FloatArray  # (entries,) [Hz], 0 for bench entries
    family: np.ndarray
    features: FloatArray
    average: sparse.csr_matrix
    bench: BenchEntries
    preload: FloatArray  # (runs,) [N]
    zero_unknown: np.ndarray  # (runs,) whether the load cell's zero is still in the run's forces
    groups: np.ndarray  # (runs,) label of each run's (condition, session)
    entry_group: np.ndarray  # (run entries,) the same of each entry
    odd: tuple[
        str, ...
    ]  # "observable of run": values left out because no other run of the condition bears them out
    run_values: FloatArray = field(repr=False)  # (channels, runs), comparison scale, NaN where unusable

    def __len__(self) -> int:
        return len(self.values)

    @property
    def run_entries(self) -> int:
        """How many of the entries (the first ones) are run entries."""
        return self.average.shape[0]
