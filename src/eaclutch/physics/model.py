"""The clutch as a function: runs and parameters in, observables out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eaclutch.physics import laws
from eaclutch.physics import rows as fill
from eaclutch.physics.effect import Parameter
from eaclutch.physics.effects import BASE, EFFECTS
from eaclutch.physics.history import run_history
from eaclutch.physics.kernels.batch import RESULTS, STATUSES, simulate_batch
from eaclutch.physics.kernels.bench import gaps_at_loads
from eaclutch.physics.observables import observable
from eaclutch.physics.parameters import MultiplierForm, base_parameters
from eaclutch.physics.prediction import OBSERVABLES, PART, Prediction, Status
from eaclutch.physics.tables import tables
from eaclutch.records import Bench, FloatArray, InputError, RunConditions

ENGAGED_FRACTION = 0.005  # of the gap's way: when the published rig can first notice the force rise
TOLERANCE = 2e-5  # local error of the film's position over its whole displacement
CHUNK = 32_768  # simulations at a time: their rows and results stay below 20 MB


class ClutchModel:
    """The clutch of a bench with a set of effects switched on.

    ``roughness_rule``: ``published`` (average cut at -``roughness_cut`` T_d / kappa) or ``clamped``;
    ``force_multiplier_form``: ``none``, ``constant``, ``linear``. Raises InputError for an unknown effect.
    """

    def __init__(
        self,
        bench: Bench,
        effects: Iterable[str] = BASE,
        *,
        roughness_rule: Literal["published", "clamped"] = "published",
        roughness_cut: float = 0.83,
        force_multiplier_form: MultiplierForm = "linear",
        tolerance: float = TOLERANCE,
    ):
        unknown = sorted(set(effects := tuple(effects)) - set(EFFECTS))
        if unknown:
            raise InputError("effects", f"unknown {', '.join(unknown)}", f"known: {', '.join(EFFECTS)}")
        if not 0.0 <= roughness_cut < 1.0:
            raise InputError("roughness_cut", f"value {roughness_cut:g}", "it must lie within [0, 1)")
        if roughness_rule not in ("published", "clamped"):
            raise InputError("roughness_rule", f"value {roughness_rule}", "choose published or clamped")
        self.bench = bench
        self.effects = tuple(name for name in EFFECTS if name in effects)
        self.roughness_rule, self.roughness_cut = roughness_rule, roughness_cut
        self.force_multiplier_form: MultiplierForm = force_multiplier_form
        self.tolerance = tolerance
        known = base_parameters(bench, force_multiplier_form)
        for name in self.effects:
            for parameter in EFFECTS[name].parameters:
                known[f"{name}.{parameter.name}"] = replace(parameter, name=f"{name}.{parameter.name}")
        self.parameters: Mapping[str, Parameter] = known

    def predict(
        self,
        conditions: RunConditions,
        parameters: Mapping[str, ArrayLike] | None = None,
        observables: Sequence[str] | None = None,
        *,
        on_invalid: Literal["error", "status"] = "error",
    ) -> Prediction:
        """Observables of every draw and run.

        ``parameters``: scalars, (draws,) or (draws, runs); missing ones take their default. ``observables``: which
        ones (None: all); parts of the simulation that none of them needs are left out. ``on_invalid``: what to do
        with parameters outside their bounds: raise InputError, or give those simulations ``Status.invalid``.
        """
        wanted = OBSERVABLES if observables is None else tuple(observables)
        for name in wanted:
            if name not in PART:
                raise InputError(
                    f"observable {name}", "the model cannot predict it", f"choose of {', '.join(PART)}"
                )
        values, draws = fill.broadcast_parameters(self.parameters, parameters or {}, len(conditions))
        share = max(1, CHUNK // max(1, len(conditions)))
        pieces = [
            self._predict_share(
                conditions, _of_draws(values, slice(i, i + share)), min(share, draws - i), wanted, on_invalid
            )
            for i in range(0, draws, share)
        ]
        return _joined(pieces) if len(pieces) > 1 else pieces[0]

    def _predict_share(
        self,
        conditions: RunConditions,
        values: fill.Values,
        draws: int,
        wanted: Sequence[str],
        on_invalid: str,
    ) -> Prediction:
        table, bad = self._rows(conditions, values, draws, on_invalid)
        out, status = self._simulate(table, {PART[name].replace("ringdown", "release") for name in wanted})
        out[bad], status[bad] = np.nan, Status.invalid
        result = {name: out[..., i] for i, name in enumerate(RESULTS)}
        parts = {name: status[..., i] for i, name in enumerate(STATUSES)}
        still = (parts["release"] == Status.ok) & (table["load_cell_dynamic"] == 0.0)
        parts["ringdown"] = np.where(still, np.int8(Status.never_slips), parts["release"])
        return Prediction(
            values={name: observable(name, result, table) for name in wanted},
            status=parts,
            state={name: result[name].copy() for name in ("preload", "gap_before", "gap_driven")},
        )

    def rows(
        self, conditions: RunConditions, parameters: Mapping[str, ArrayLike], on_invalid: str = "error"
    ) -> tuple[NDArray[np.void], NDArray[np.bool_]]:
        """The solver's rows (draws, runs) and which of them are invalid (those hold the defaults)."""
        values, draws = fill.broadcast_parameters(self.parameters, parameters, len(conditions))
        return self._rows(conditions, values, draws, on_invalid)

    def _rows(
        self, conditions: RunConditions, values: fill.Values, draws: int, on_invalid: str
    ) -> tuple[NDArray[np.void], NDArray[np.bool_]]:
        runs = len(conditions)
        # a run whose inputs are missing cannot be simulated, whatever the parameters
        missing = (
            np.isnan(conditions.friction_before) | np.isnan(conditions.voltage) | np.isnan(conditions.width)
        )
        if missing.any():
            conditions = replace(conditions, friction_before=np.where(missing, 0.1, conditions.friction_before),
                                 voltage=np.where(missing, 100.0, conditions.voltage),
                                 width=np.where(missing, 2e-3, conditions.width))  # fmt: skip
        bad = np.broadcast_to(missing, (draws, runs)).copy()
        if on_invalid == "error":
            fill.refuse_outside(self.parameters, values)
        else:
            outside = fill.outside(self.parameters, values, draws, runs)
            bad |= outside
            if outside.any():  # the formulas see bounded numbers everywhere
                values = {n: np.where(_inside(v, self.parameters[n]), v, self.parameters[n].default)
                          for n, v in values.items()}  # fmt: skip
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            sockets = fill.fill_sockets(self.bench, conditions, values, self.effects)
            clamped = self.roughness_rule == "clamped"
            table = fill.fill_rows(self.bench, conditions, values, sockets, self.force_multiplier_form, clamped,
                                   self.roughness_cut, draws)  # fmt: skip
        limits = (
            (
                "force_scale",
                table["force_scale"] <= 0,
                "the force multiplier must stay positive at every voltage",
            ),
            ("thinning_ratio", table["thinning_ratio"] >= 0.9, "the film may thin by less than 90 %"),
            ("kappa_driven", table["kappa_driven"] < 0.5, "the permittivity must stay above that of vacuum"),
        )
        for name, unphysical, remedy in limits:
            if not unphysical.any():
                continue
            if on_invalid == "error":
                raise InputError(f"socket {name}", f"value {table[name][unphysical].flat[0]:g}", remedy)
            bad |= unphysical
            table[name][unphysical] = {"force_scale": 1e-20, "thinning_ratio": 0.0, "kappa_driven": 50.0}[
                name
            ]
        return table, bad

    def _simulate(self, table: NDArray[np.void], parts: set[str]) -> tuple[FloatArray, NDArray[np.int8]]:
        flat = table.reshape(-1)
        out = np.empty((flat.size, len(RESULTS)))
        status = np.empty((flat.size, len(STATUSES)), dtype=np.int8)
        simulate_batch(flat, tables(), "engagement" in parts, "release" in parts, ENGAGED_FRACTION, self.tolerance,
                       out, status)  # fmt: skip
        return out.reshape(*table.shape, -1), status.reshape(*table.shape, -1)

    def permittivity(
        self, frequency: ArrayLike, parameters: Mapping[str, ArrayLike] | None = None
    ) -> FloatArray:
        """Real relative permittivity (draws, points) at ``frequency`` [Hz]."""
        values, _ = fill.broadcast_parameters(self.parameters, parameters or {}, 1)
        fill.refuse_outside(self.parameters, values)
        frequency = np.atleast_1d(np.asarray(frequency, dtype=float))
        relaxed = laws.permittivity(frequency, values["kappa_static"], values["kappa_infinity"],
                                    values["relaxation_time"], values["cole_cole_exponent"])  # fmt: skip
        weight = values.get("dielectric_relaxation.strength", np.zeros((1, 1)))
        if "dielectric_relaxation" in self.effects and "dielectric_relaxation.strength" not in values:
            weight = np.ones((1, 1))
        return values["kappa_static"] + weight * (relaxed - values["kappa_static"])

    def slip_overshoot(self, values: Mapping[str, ArrayLike]) -> FloatArray:
        """Share by which a slip overshoots the kinetic friction, for parameters by name (missing ones: default), with
        the bare load cell's damping; 0 without its dynamics."""
        if "load_cell_dynamics" not in self.effects:
            return np.zeros(())
        given = (values.get(n, self.parameters[n].default) for n in ("stiffness", "mass", "damping"))
        return laws.slip_overshoot(*(np.asarray(value, dtype=float) for value in given))

    def capacitance(
        self, force: ArrayLike, width: ArrayLike, parameters: Mapping[str, ArrayLike] | None = None
    ) -> FloatArray:
        """Capacitance [F] (draws, readings) on the fixture under a normal ``force`` [N] at a strip ``width`` [m],
        at the meter's frequency, stray capacitance included."""
        force, width = np.broadcast_arrays(np.atleast_1d(np.asarray(force, float)), np.asarray(width, float))
        fixture = self.bench.fixture
        conditions = _fixture_conditions(width, fixture.meter_frequency)
        values, draws = fill.broadcast_parameters(self.parameters, parameters or {}, len(conditions))
        fill.refuse_outside(self.parameters, values)
        sockets = fill.fill_sockets(self.bench, conditions, values, self.effects)
        sockets = sockets.with_(
            gap_spread_sd=sockets.fixture_gap_spread_sd,
            gap_levelling=0.0,
            adhesion_force=sockets.fixture_adhesion_force,
        )
        table = fill.fill_rows(
            self.bench, conditions, values, sockets, "none", False, self.roughness_cut, draws
        )
        for name in ("contact_scale", "adhesion_force"):  # both per area of the pad's overlap
            table[name] *= fixture.overlap_length / self.bench.pad.overlap_length
        gap = np.empty(table.shape)
        gaps_at_loads(
            table.reshape(-1), np.broadcast_to(force, table.shape).ravel(), tables(), gap.reshape(-1)
        )
        film = table["thickness"] / table["kappa_driven"]
        scale = laws.capacitance_scale(self.bench.pad, width, fixture.overlap_length)
        inverse = laws.mean_inverse_distance(film, gap, table["gap_half_spread"])
        return scale * inverse + values["stray_capacitance"] + np.asarray(sockets.stray_capacitance)

    def history(
        self,
        conditions: RunConditions,
        run_index: int,
        parameters: Mapping[str, ArrayLike] | None,
        time: FloatArray,
        *,
        capacity_factors: FloatArray | None = None,
    ) -> FloatArray:
        """Noiseless reading [N] (samples,) of one whole run at ``time`` [s] from voltage on (negative before it).

        One draw of parameters. ``capacity_factors`` (slips,): scatter of the static capacity from slip to slip,
        multiplying it in turn (the last one repeats); without it every slip is alike.
        """
        one = conditions.select(np.array([run_index]))
        table, _ = self.rows(one, {n: _of_run(v, run_index) for n, v in (parameters or {}).items()})
        return run_history(table[0, 0], np.asarray(time, dtype=float), capacity_factors, self.tolerance)


def _of_draws(values: fill.Values, share: slice) -> fill.Values:
    return {name: value if value.shape[0] == 1 else value[share] for name, value in values.items()}


def _joined(pieces: Sequence[Prediction]) -> Prediction:
    def join(parts: Sequence[Mapping[str, NDArray]]) -> dict[str, NDArray]:
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    return Prediction(
        values=join([piece.values for piece in pieces]),
        status=join([piece.status for piece in pieces]),
        state=join([piece.state for piece in pieces]),
    )


def _inside(value: FloatArray, parameter: Parameter) -> NDArray[np.bool_]:
    low, high = parameter.bounds
    return (value >= low) & (value <= high)


def _of_run(value: ArrayLike, run: int) -> FloatArray:
    array = np.asarray(value, dtype=float)
    return array[:, run : run + 1] if array.ndim == 2 and array.shape[1] > 1 else array


def _fixture_conditions(width: FloatArray, frequency: float) -> RunConditions:
    n = width.size
    zero = np.zeros(n)
    names = ("",) * n
    return RunConditions(
        run=names, session=names, condition=names, substrate=names, voltage=zero, frequency=np.full(n, frequency),
        width=np.array(width), thickness=np.full(n, 1e-3), friction_before=np.full(n, 0.1), switch_off_force=zero,
        drive_duration=np.ones(n), dwell=zero, run_order=zero,
    )  # fmt: skip
