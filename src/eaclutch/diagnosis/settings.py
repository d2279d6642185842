"""The thresholds file: numbers that turn scores into words, read once and checked."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from eaclutch.records import InputError

DEFAULT = Path(__file__).with_name("thresholds.yaml")
REQUIRED = ("provenance", "session_sd", "session_together", "tolerance", "scatter", "repeat_drift", "repeat_sd",
            "repeat_prior_dof", "unrepeated_sd", "within_block_correlation", "tolerance_shares", "length_scales",
            "signature_tolerance", "multipliers", "nameless", "modulated", "remainder_cost", "pair_widening",
            "one_condition", "against_unknown", "unknown_odds", "free_swing", "misfit_share", "misfit_remainder",
            "large_gap", "partly", "widening", "narrowing_weight", "prior", "priors", "temperature", "verdict", "place",
            "caveats", "sentences")  # fmt: skip


@cache
def load_thresholds(path: Path = DEFAULT) -> Mapping[str, Any]:
    """The thresholds as a nested mapping.

    Raises: InputError where the file cannot be read or a group is missing.
    """
    try:
        thresholds = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise InputError(path, f"unreadable thresholds ({error})", "restore the file") from error
    missing = [name for name in REQUIRED if name not in (thresholds or {})]
    if missing:
        raise InputError(path, f"no {missing[0]!r}", "restore the file")
    return thresholds
