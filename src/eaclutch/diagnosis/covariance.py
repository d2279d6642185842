"""What a residual may be without being an effect: repeat noise, session spread, model-form tolerance.

All three are Gaussian on the comparison scale. A tolerance is smooth over the settings: a base law that is
wrong by 5 % is wrong by 5 % at the neighbouring voltage too, and must not be taken for twenty independent
confirmations of an effect.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from eaclutch.diagnosis.data import DataVector
from eaclutch.records import FloatArray


@dataclass(frozen=True)
class Kernels:
    """Correlation matrices (entries, entries) of a data vector, worked out once a campaign."""

    noise_variance: FloatArray  # (entries,) of the repeats' mean
    shared_noise: FloatArray  # what repeats have in common: offsets of a bench's trials, place of voltage off
    scatter_variance: (
        FloatArray  # (entries,) what the model misses of one (condition, session) apart from others
    )
    session: FloatArray  # scaled by the blocks' session sds
    tolerance: FloatArray  # scaled by the blocks' tolerances
    smooth: FloatArray  # correlation of an effect's own law being off, within and across channels

    def total(
        self,
        *,
        tolerance: FloatArray | float = 1.0,
        session: FloatArray | float = 1.0,
        signature: FloatArray | None = None,
        signature_tolerance: float = 0.0,
        scatter: bool = True,
    ) -> FloatArray:
        """Covariance (entries, entries). ``tolerance`` and ``session`` multiply the sds (a number or one an
        entry); ``signature`` (entries,) is an effect's own shift of the prediction; ``scatter``: False leaves out
        what only the model misses."""
        t = np.broadcast_to(np.asarray(tolerance, float), self.noise_variance.shape)
        s = np.broadcast_to(np.asarray(session, float), self.noise_variance.shape)
        out = self.shared_noise + self.session * np.outer(s, s) + self.tolerance * np.outer(t, t)
        if signature is not None and signature_tolerance > 0:
            scaled = signature_tolerance * signature
            out = out + self.smooth * np.outer(scaled, scaled)
        out[np.diag_indices_from(out)] += self.noise_variance + (self.scatter_variance if scatter else 0.0)
        return out


def kernels(data: DataVector, thresholds: Mapping[str, Any]) -> Kernels:
    """Correlations of a campaign's entries from the thresholds file."""
    shares = thresholds["tolerance_shares"]
    rho = float(thresholds["within_block_correlation"])
    same_block = data.block[:, None] == data.block[None, :]
    same_channel = data.channel[:, None] == data.channel[None, :]
    same_family = data.family[:, None] == data.family[None, :]
    between = np.where(same_channel, 1.0, np.where(same_block, rho, 0.0))
    session_sd = np.array([thresholds["session_sd"][b] for b in data.block])
    same_offset = (data.offset[:, None] == data.offset[None, :]) & same_family
    tolerance_sd = np.array([thresholds["tolerance"][b] for b in data.block])
    shape = _smooth(data, shares)
    across = np.where(same_family, np.where(same_channel, 1.0, rho), 0.0)
    same_frequency = data.frequency[:, None] == data.frequency[None, :]
    offsets = np.outer(data.offset_sd, data.offset_sd) * same_offset
    edges = np.outer(data.edge_sd, data.edge_sd) * same_frequency + np.outer(data.fall_sd, data.fall_sd)
    scatter = np.array([thresholds["scatter"].get(b, 0.0) for b in data.block])
    tolerance = np.outer(tolerance_sd, tolerance_sd) * between * same_family * shape
    return Kernels(
        data.noise_sd**2,
        offsets + edges,
        scatter**2,
        np.outer(session_sd, session_sd) * between * same_offset,
        tolerance,
        across * shape,
    )


def _smooth(data: DataVector, shares: Mapping[str, float]) -> FloatArray:
    """Unit-variance correlation over the settings: constant + additive + joint + one value a condition."""
    difference = data.features[:, None, :] - data.features[None, :, :]
    squared = difference**2
    additive = np.mean(np.exp(-0.5 * squared), axis=2)
    joint = np.exp(-0.5 * np.sum(squared, axis=2))
    label = np.where(data.condition == "", np.arange(len(data)).astype(str).astype(object), data.condition)
    same_condition = (label[:, None] == label[None, :]).astype(float)
    total = sum(shares.values())
    return (
        shares["constant"] + shares["additive"] * additive + shares["joint"] * joint
        + shares["condition"] * same_condition
    ) / total  # fmt: skip
