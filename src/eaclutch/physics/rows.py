"""From bench, runs, parameters and effects to the solver's rows; bad values end here, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eaclutch.physics import laws
from eaclutch.physics.effect import Inputs, Parameter
from eaclutch.physics.effects import EFFECTS
from eaclutch.physics.kernels.row import ROW
from eaclutch.physics.parameters import MultiplierForm, force_multiplier
from eaclutch.physics.sockets import Sockets
from eaclutch.records import Bench, FloatArray, InputError, RunConditions, Substrate

Values = Mapping[str, FloatArray]


def broadcast_parameters(
    known: Mapping[str, Parameter], given: Mapping[str, ArrayLike], runs: int
) -> tuple[dict[str, FloatArray], int]:
    """Every known parameter as (draws or 1, runs or 1), defaults filled, and the number of draws.

    Raises: InputError for an unknown name or shapes that do not broadcast to (draws, runs).
    """
    unknown = sorted(set(given) - set(known))
    if unknown:
        raise InputError("parameters", f"unknown {', '.join(unknown)}", f"known: {', '.join(known)}")
    values, draws, setter = {}, 1, ""
    for name, parameter in known.items():
        value = np.asarray(given.get(name, parameter.default), dtype=float)
        if value.ndim > 2 or (value.ndim == 2 and value.shape[1] not in (1, runs)):
            raise InputError(
                f"parameter {name}", f"shape {value.shape}", f"give (), (draws,) or (draws, {runs})"
            )
        value = value.reshape(1, 1) if value.ndim == 0 else value[:, None] if value.ndim == 1 else value
        if value.shape[0] != 1:
            if draws not in (1, value.shape[0]):
                raise InputError(f"parameter {name}", f"{value.shape[0]} draws, but {setter} has {draws}",
                                 "give every array the same number of draws")  # fmt: skip
            draws, setter = value.shape[0], name
        values[name] = value
    return values, draws


def outside(known: Mapping[str, Parameter], values: Values, draws: int, runs: int) -> NDArray[np.bool_]:
    """Mask (draws, runs) of simulations with a value outside its bounds (or not finite)."""
    bad = np.zeros((draws, runs), dtype=bool)
    for name, value in values.items():
        low, high = known[name].bounds
        bad |= ~((value >= low) & (value <= high))
    return bad


def refuse_outside(known: Mapping[str, Parameter], values: Values) -> None:
    """Raise InputError naming the first parameter outside its bounds, its value and the bounds."""
    for name, value in values.items():
        low, high = known[name].bounds
        bad = ~((value >= low) & (value <= high))
        if bad.any():
            raise InputError(
                f"parameter {name}",
                f"value {value[bad].flat[0]:g} {known[name].unit}",
                f"it must lie within [{low:g}, {high:g}] {known[name].unit}",
            )


def substrate_mass(bench: Bench, conditions: RunConditions) -> FloatArray:
    """Mass of each run's strip [kg], what it carries along included, (runs,)."""
    kinds = {name: bench.substrates.get(name) for name in set(conditions.substrate)}
    default = next(iter(bench.substrates.values()), Substrate())
    each = [kinds[name] or default for name in conditions.substrate]
    density = np.array([kind.density for kind in each])
    length = np.array([kind.length for kind in each])
    extra = np.array([kind.extra_mass for kind in each])
    return density * length * conditions.width * conditions.thickness + extra


def fill_sockets(bench: Bench, conditions: RunConditions, values: Values, effects: Sequence[str]) -> Sockets:
    """The sockets after every switched-on effect, in the order of the stages."""
    pad = bench.pad
    mass = substrate_mass(bench, conditions)
    film_mass = bench.film_density * values["film_thickness"] * pad.overlap_length * conditions.width
    area = conditions.width * (pad.overlap_length if pad.type == "parallel_plate" else pad.electrode_length)
    inputs = Inputs(
        bench=bench,
        conditions=conditions,
        parameters=values,
        preload=laws.base_preload(
            conditions.friction_before, values["film_kinetic"], values["base_kinetic"], mass, film_mass
        ),
        area=area,
        film_mass=film_mass,
        substrate_mass=mass,
        capacitance=laws.capacitance(
            pad, conditions.width, 0.0, values["kappa_static"], values["film_thickness"]
        ),
        session_index=np.asarray(conditions.session_number, dtype=np.intp),
    )
    sockets = Sockets()
    for name, effect in EFFECTS.items():
        if name in effects:
            own = {p.name: values[f"{name}.{p.name}"] for p in effect.parameters}
            sockets = effect.apply(sockets, inputs, own)
    return sockets


def fill_rows(
    bench: Bench, conditions: RunConditions, values: Values, sockets: Sockets, form: MultiplierForm, clamped: bool,
    cut: float, draws: int,
) -> NDArray[np.void]:  # fmt: skip
    """Rows (draws, runs) of the solver's record."""
    rows = np.empty((draws, len(conditions)), dtype=ROW)
    pad, width = bench.pad, conditions.width
    sigma = values["roughness_sd"]
    kappa = np.asarray(sockets.kappa_driven)
    multiplier = force_multiplier(values, conditions.voltage, form)
    fields: dict[str, ArrayLike] = {
        "voltage": conditions.voltage,
        "kappa_driven": np.where(np.isnan(kappa), values["kappa_static"], kappa),
        "exponent": values["cole_cole_exponent"],
        "thickness": values["film_thickness"],
        "force_scale": laws.force_scale(pad, width) * multiplier * sockets.force_factor,
        "clamped": float(clamped),
        "cut": cut,
        "contact_scale": values["contact_stiffness"]
        * sockets.contact_factor
        * pad.overlap_length
        * width
        * sigma**1.5,
        "sigma": sigma,
        "inverse_sigma": 1.0 / sigma,
        "gap_half_spread": np.sqrt(3.0) * np.asarray(sockets.gap_spread_sd),
        "film_mass": bench.film_density * values["film_thickness"] * pad.overlap_length * width,
        "damping": laws.squeeze_film_coefficient(pad.overlap_length, width) * sockets.damping_factor,
        "substrate_weight": laws.GRAVITY * substrate_mass(bench, conditions),
        "load_cell_damping": values["damping"],
        **{
            name: values[name] * sockets.friction_factor
            for name in ("film_static", "film_kinetic", "base_static", "base_kinetic")
        },
        "friction_before": conditions.friction_before,
        "switch_off_force": conditions.switch_off_force - sockets.reading_drift * conditions.drive_duration,
        "drive_duration": conditions.drive_duration,
        "dwell": conditions.dwell,
        "stage_speed": bench.stage_speed * sockets.stage_speed_factor,
    }
    for name in ROW.names or ():
        if name not in fields:
            fields[name] = getattr(sockets, name) if hasattr(sockets, name) else values[name]
        rows[name] = fields[name]
    return rows
