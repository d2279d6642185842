"""The configured set of design maps, for the campaign's pad and for the other kind of pad."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.physics.effects import switched_on
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, FloatArray
from eaclutch.studies.sweep import Design, DesignMap, design_map

# Limits are stated in the units people design with.
LIMIT_UNITS = {"engagement_us": ("engagement_time_s", 1e-6), "release_ms": ("release_time_90_s", 1e-3)}


@dataclass(frozen=True)
class PadMap:
    """A design map of one kind of pad."""

    pad: str
    map: DesignMap


def limits_of(sweep: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """The config's limits as (low, high) per observable, SI."""
    limits = {
        observable: (0.0, sweep["limits"][key] * unit) for key, (observable, unit) in LIMIT_UNITS.items()
    }
    return limits | {"shear_capacity_n": (sweep["limits"]["capacity_n"], np.inf)}


def model_of(bench: Bench, model: Mapping[str, Any]) -> ClutchModel:
    """The clutch of a bench as the config's ``model`` part asks for it."""
    return ClutchModel(
        bench,
        switched_on(model),
        roughness_rule=model["roughness_rule"],
        roughness_cut=model["roughness_cut"],
        force_multiplier_form=model["force_multiplier_form"],
    )


def draw_maps(bench: Bench, config: Mapping[str, Any], draws: Mapping[str, FloatArray]) -> list[PadMap]:
    """All maps of the config's ``sweep`` part, with the effects of its ``model`` part."""
    sweep = config["sweep"]
    design = Design(sorted(bench.substrates)[0], **sweep["design"])
    build = partial(model_of, model=config["model"])
    known = build(bench).parameters
    used = {name: value for name, value in draws.items() if name in known}
    maps = []
    for pad in sweep["pads"]:
        changed = replace(bench, pad=replace(bench.pad, type=pad))
        for names in sweep["maps"]:
            x, y = ((name, levels(sweep, name)) for name in names)
            maps.append(PadMap(pad, design_map(changed, build, used, design, x, y)))
    return maps


def design_levels(bench: Bench, design: Mapping[str, float]) -> dict[str, float]:
    """Level of every axis at the design point: the config's, and the bench's for what the config does not state."""
    own = {
        "film_thickness_um": bench.pad.film_thickness * 1e6,
        "overlap_length_mm": bench.pad.overlap_length * 1e3,
        "drive_time_us": bench.drive.rise_10_90 * 1e6,
        "electrodes": float(bench.pad.electrodes),
    }
    return own | dict(design)


def levels(sweep: Mapping[str, Any], name: str) -> FloatArray:
    """The levels of one axis: evenly spaced within the config's range, drive times and frequencies in the log."""
    low, high = sweep["ranges"][name]
    spaced = np.geomspace if name in ("drive_time_us", "frequency_hz") else np.linspace
    return spaced(low, high, sweep["levels"])


def maps_table(maps: list[PadMap], sweep: Mapping[str, Any]) -> pd.DataFrame:
    """Long table: pad, axes and levels, observable, q05, median, q95, and the probability of meeting the limits."""
    parts = []
    for entry in maps:
        drawn = entry.map
        x, y = (level.ravel() for level in np.meshgrid(drawn.x, drawn.y))
        probability = drawn.probability(limits_of(sweep)).ravel()
        for observable in drawn.values:
            low, median, high = (q.ravel() for q in drawn.quantiles(observable))
            columns = {"pad": entry.pad, "x_name": drawn.x_name, "x": x, "y_name": drawn.y_name, "y": y}
            columns |= {"observable": observable, "q05": low, "median": median, "q95": high}
            parts.append(pd.DataFrame(columns | {"probability_within_limits": probability}))
    return pd.concat(parts, ignore_index=True)
