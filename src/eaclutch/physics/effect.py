"""What an effect is: one frozen record, the same kind of thing for the base model and for candidates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from eaclutch.physics.sockets import Sockets
from eaclutch.records import DC_LABEL, Bench, FloatArray, RunConditions

Stage = Literal[
    "session", "drive", "dielectric", "electrostatics", "contact", "film", "friction", "load_train",
    "readout", "capacitance_bench",
]  # fmt: skip
REFERENCE_WIDTH = 2e-3  # m, the narrowest strip of the published bench
REFERENCE_VOLTAGE = 300.0  # V, the rig's highest
SESSIONS = 8  # told apart by an effect that has a value for each; later ones share the last one's


@dataclass(frozen=True)
class Prior:
    """A one-dimensional prior: ``normal`` (a mean, b sd), ``lognormal`` (a median, b sd of the log),
    ``halfnormal`` (a scale), ``uniform`` (a low, b high), ``loguniform`` (a low, b high)."""

    distribution: Literal["normal", "lognormal", "halfnormal", "uniform", "loguniform"]
    a: float
    b: float = 0.0


@dataclass(frozen=True)
class Parameter:
    """A model parameter. ``neutral``: the value that switches its effect off exactly (None: calibrated base
    parameter, or a parameter that does nothing while its effect's amplitude is neutral)."""

    name: str
    unit: str
    bounds: tuple[float, float]
    default: float
    prior: Prior
    neutral: float | None = None
    description: str = ""


@dataclass(frozen=True)
class Inputs:
    """What an effect may look at: bench, runs and derived arrays, each (draws, runs) or broadcastable.

    preload [N]: estimated from the friction before with the base model; area [m2]: overlap L_e w_s;
    capacitance [F] of the closed pad (for drive time constants); substrate_mass, film_mass [kg];
    parameters: the calibrated base parameters of this prediction; session_index: 0.. in order of time.
    """

    bench: Bench
    conditions: RunConditions
    parameters: Mapping[str, FloatArray]
    preload: FloatArray
    area: FloatArray
    film_mass: FloatArray
    substrate_mass: FloatArray
    capacitance: FloatArray
    session_index: np.ndarray

    @property
    def relative_width(self) -> FloatArray:
        """Width over that of the narrowest strip of the published bench."""
        return self.conditions.width / REFERENCE_WIDTH

    @property
    def relative_voltage(self) -> FloatArray:
        """Drive amplitude over the rig's highest; 1 V stands in for none, which has no power below 0."""
        return np.maximum(self.conditions.voltage, 1.0) / REFERENCE_VOLTAGE

    @property
    def polarity_time(self) -> FloatArray:
        """How long the drive holds one polarity [s]: half a period, and never longer than the drive itself (DC)."""
        runs = self.conditions
        half_wave = np.where(runs.frequency > DC_LABEL, 0.5 / runs.frequency, np.inf)
        return np.minimum(half_wave, runs.drive_duration)

    def of_session(self, values: Sequence[FloatArray | float]) -> FloatArray:
        """The value of each run's session, of ``values`` in order of time; later sessions share the last one's."""
        session = np.minimum(self.session_index, len(values) - 1)
        found: FloatArray = np.zeros(session.shape)
        for number, value in enumerate(values):
            found = found + np.where(session == number, 1.0, 0.0) * value
        return found

    @property
    def film_field(self) -> FloatArray:
        """Nominal field in the film where the gap is closed [V/m]: (V/2) / T_d, or V / T_d of a plate."""
        drop = 2.0 if self.bench.pad.type == "interdigitated" else 1.0
        return self.conditions.voltage / (drop * self.parameters["film_thickness"])


@dataclass(frozen=True)
class Effect:
    """A physical effect: where it acts, its parameters, its law as a pure function on sockets.

    ``apply(sockets, inputs, values)``: new sockets; ``values`` maps the effect's parameter names (without the
    prefix) to arrays that broadcast to (draws, runs). ``draw(rng)``: a plausible random parameter set for
    studies. ``role``: the base model has it on; a candidate may be named; a lookalike is what a bench may do that the
    library has no name for: it competes, and what it wins is ``unknown``'s. ``exact``: its law has no other form.
    """

    name: str
    role: Literal["base", "candidate", "lookalike"]
    stage: Stage
    action: Literal["adds", "multiplies", "replaces"]
    summary: str
    parameters: tuple[Parameter, ...]
    reference: str
    validity: str
    apply: Callable[[Sockets, Inputs, Mapping[str, FloatArray]], Sockets]
    draw: Callable[[np.random.Generator], dict[str, float]]
    exact: bool = False


STRENGTH = Parameter(
    "strength", "1", (0.0, 1.0), 1.0, Prior("uniform", 0.0, 1.0), neutral=0.0,
    description="1: as the law says, 0: exactly off; the base model keeps it at 1",
)  # fmt: skip
"""The one parameter of every base effect: a weight, fixed at 1 unless the effect is itself a candidate."""


def fixture_share(what: str) -> Parameter:
    """How much of ``what`` an effect does to the clutch the capacitance fixture has, a mounting of its own."""
    return Parameter(
        "fixture_share", "1", (0.0, 1.0), 1.0, Prior("uniform", 0.0, 1.0),
        description=f"share of the {what} that the capacitance fixture has too",
    )  # fmt: skip
