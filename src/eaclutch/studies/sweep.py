"""Design maps: engagement, release and shear capacity over any two quantities of a clutch's design.

As the paper's Fig. 10, with the posterior's band instead of a line, and the inverse: the probability that a
design meets stated limits. Source: Rauf & Follmer (2025), Sec. 5, doi:10.1016/j.eml.2025.102382.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.constants import g as GRAVITY

from eaclutch.physics.kernels.ramp import LEVEL_SPAN
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, FloatArray, InputError, RunConditions

# A design's quantities: those of a run, and those that change the bench.
RUN_AXES = ("voltage_v", "frequency_hz", "width_mm", "preload_n")
BENCH_AXES: Mapping[str, Callable[[Bench, float], Bench]] = {
    "film_thickness_um": lambda bench, x: replace(bench, pad=replace(bench.pad, film_thickness=x * 1e-6)),
    "overlap_length_mm": lambda bench, x: _with_length(bench, x * 1e-3),
    "drive_time_us": lambda bench, x: replace(
        bench, drive=replace(bench.drive, rise_10_90=x * 1e-6, fall_90_10=x * 1e-6)
    ),
    "electrodes": lambda bench, x: replace(bench, pad=replace(bench.pad, electrodes=round(x))),
}
AXES = (*RUN_AXES, *BENCH_AXES)


def _with_length(bench: Bench, length: float) -> Bench:
    """A longer overlap needs a longer strip and, on a comb, proportionally more electrodes."""
    pad, ratio = bench.pad, length / bench.pad.overlap_length
    electrodes = max(2, round(pad.electrodes * ratio)) if pad.type == "interdigitated" else pad.electrodes
    substrates = {
        name: replace(strip, length=strip.length + length - pad.overlap_length)
        for name, strip in bench.substrates.items()
    }
    return replace(
        bench, pad=replace(pad, overlap_length=length, electrodes=electrodes), substrates=substrates
    )


@dataclass(frozen=True)
class Design:
    """The point around which maps are drawn (the paper's: 2 mm, 300 V, 1 kHz, 0.125 N, start ratio 0.8)."""

    substrate: str
    voltage_v: float = 300.0
    frequency_hz: float = 1000.0
    width_mm: float = 2.0
    preload_n: float = 0.125
    start_ratio: float = 0.8


@dataclass(frozen=True)
class DesignMap:
    """A map over (x, y): ``values[observable]`` has shape (draws, y levels, x levels), NaN where the status of
    that draw is not ok; axes as given, in the unit of their name."""

    x_name: str
    y_name: str
    x: FloatArray
    y: FloatArray
    values: Mapping[str, FloatArray]

    def quantiles(self, observable: str, levels: Sequence[float] = (0.05, 0.5, 0.95)) -> FloatArray:
        """Posterior quantiles, shape (levels, y, x); NaN where more than half of the draws have no value."""
        values = self.values[observable]
        enough = np.isfinite(values).mean(axis=0) >= 0.5
        shown = np.where(enough, values, 0.0)
        return np.where(enough, np.nanquantile(shown, levels, axis=0), np.nan)

    def probability(self, limits: Mapping[str, tuple[float, float]]) -> FloatArray:
        """Probability that every observable lies within its (low, high), shape (y, x); no value is a miss."""
        met = np.ones(next(iter(self.values.values())).shape, dtype=bool)
        for observable, (low, high) in limits.items():
            met &= (self.values[observable] >= low) & (self.values[observable] <= high)
        return met.mean(axis=0)


OBSERVABLES = ("engagement_time_s", "release_time_90_s", "shear_capacity_n")
STATUS_OF = {
    "engagement_time_s": "engagement",
    "release_time_90_s": "release",
    "shear_capacity_n": "capacity",
}


def design_map(
    bench: Bench,
    model_of: Callable[[Bench], ClutchModel],
    draws: Mapping[str, FloatArray],
    design: Design,
    x: tuple[str, Sequence[float] | FloatArray],
    y: tuple[str, Sequence[float] | FloatArray],
) -> DesignMap:
    """Predict the three observables over x and y for every draw.

    ``model_of`` builds the model of a bench; ``draws``: calibrated parameters, each (draws,). An axis is one of
    ``AXES``. Raises InputError for an unknown axis.
    """
    for name, _ in (x, y):
        if name not in AXES:
            raise InputError(
                f"sweep.{name}", "is not an axis of a design map", f"use one of {', '.join(AXES)}"
            )
    if "film_thickness_um" in (x[0], y[0]):
        # The axis states the thickness; the calibrated one describes the pad as built.
        draws = {name: value for name, value in draws.items() if name != "film_thickness"}
    count = len(next(iter(draws.values())))
    shape = (count, len(y[1]), len(x[1]))
    values = {name: np.full(shape, np.nan) for name in OBSERVABLES}
    # Levels that change the bench need a model each; all levels of the run go through one call.
    bench_x = [x] if x[0] in BENCH_AXES else []
    bench_y = [y] if y[0] in BENCH_AXES else []
    for i, x_level in enumerate(x[1]) if bench_x else [(slice(None), None)]:
        for j, y_level in enumerate(y[1]) if bench_y else [(slice(None), None)]:
            changed = bench
            for axis, level in ((x, x_level), (y, y_level)):
                if level is not None:
                    changed = BENCH_AXES[axis[0]](changed, float(level))
            levels_x = x[1] if x_level is None else [x_level]
            levels_y = y[1] if y_level is None else [y_level]
            grid = {x[0]: np.tile(levels_x, len(levels_y)), y[0]: np.repeat(levels_y, len(levels_x))}
            predicted = _predict(changed, model_of(changed), draws, design, grid)
            for name, value in predicted.items():
                block = value.reshape(count, len(levels_y), len(levels_x))
                rows = slice(None) if y_level is None else slice(j, j + 1)  # type: ignore[operator]
                columns = slice(None) if x_level is None else slice(i, i + 1)  # type: ignore[operator]
                values[name][:, rows, columns] = block
    return DesignMap(x[0], y[0], np.asarray(x[1], float), np.asarray(y[1], float), values)


def _predict(
    bench: Bench,
    model: ClutchModel,
    draws: Mapping[str, FloatArray],
    design: Design,
    grid: Mapping[str, FloatArray],
) -> dict[str, FloatArray]:
    conditions = design_conditions(bench, design, grid)
    capacity = model.predict(conditions, draws, ["shear_capacity_n"])
    # The paper starts a release from a fixed share of the capacity; the draws share its median here.
    held = design.start_ratio * (
        np.nanmedian(capacity.values["shear_capacity_n"], axis=0) + conditions.friction_before
    )
    conditions = replace(conditions, switch_off_force=held)
    prediction = model.predict(conditions, draws, list(OBSERVABLES))
    return {
        name: np.where(prediction.status[STATUS_OF[name]] == 0, prediction.values[name], np.nan)
        for name in OBSERVABLES
    }


def design_conditions(bench: Bench, design: Design, grid: Mapping[str, FloatArray]) -> RunConditions:
    """The runs of a grid; the friction before the voltage follows from the preload (physics.md item 9)."""
    n = len(next(iter(grid.values())))

    def level(name: str, default: float) -> FloatArray:
        return np.asarray(grid.get(name, np.full(n, default)), dtype=float)

    strip = bench.substrates[design.substrate]
    width = level("width_mm", design.width_mm) * 1e-3
    widths = np.array(sorted(strip.thickness))
    thickness = np.array([strip.thickness[widths[np.argmin(np.abs(widths - w))]] for w in width])
    substrate_mass = strip.density * strip.length * width * thickness + strip.extra_mass
    film_mass = bench.film_density * bench.pad.film_thickness * bench.pad.overlap_length * width
    friction, preload = bench.friction, level("preload_n", design.preload_n)
    on_film, on_base = friction.film_kinetic.mean, friction.base_kinetic.mean
    before = (on_film + on_base) * preload + GRAVITY * (on_base * substrate_mass + on_film * film_mass)
    names = ("design",) * n
    # the stage has stopped: a release starts from the very force that a design states
    return RunConditions(
        run=names, session=names, condition=names, substrate=(design.substrate,) * n,
        voltage=level("voltage_v", design.voltage_v), frequency=level("frequency_hz", design.frequency_hz),
        width=width, thickness=thickness, friction_before=before, switch_off_force=np.full(n, np.nan),
        drive_duration=np.full(n, 3.0), dwell=np.full(n, LEVEL_SPAN), run_order=np.zeros(n),
    )  # fmt: skip
