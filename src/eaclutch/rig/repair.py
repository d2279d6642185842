"""Put columns that lost lines back in step, only where the hole can be located with certainty."""

from __future__ import annotations

import numpy as np

from eaclutch.records import Recording


def repair(recording: Recording) -> Recording:
    """The recording with what could be repaired with certainty, flags saying what was found and done."""
    return recording


def spoiled_samples(recording: Recording) -> np.ndarray:
    """Samples (bool, (samples,)) whose force cannot be trusted or placed in time."""
    return ~np.isfinite(recording.force)
