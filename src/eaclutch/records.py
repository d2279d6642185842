"""Frozen records that the rooms exchange. SI units; in arrays draws lead and runs come last."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[Any]  # of floats; which precision is not typed
DC_LABEL = 0.1  # Hz, the rig's way to write DC


class InputError(ValueError):
    """Input that cannot be used: where (file, row or key), what is wrong, and the remedy.

    The command line prints it as the one line ``eaclutch: error: <where>: <what>; <remedy>``.
    """

    def __init__(self, where: object, what: str, remedy: str):
        self.where, self.what, self.remedy = str(where), what, remedy
        super().__init__(" ".join(f"{where}: {what}; {remedy}".split()))

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str]]:
        """Another process raises it again whole."""
        return InputError, (self.where, self.what, self.remedy)


@dataclass(frozen=True)
class Gaussian:
    """Mean and standard deviation of a prior, in the unit of the field that holds it."""

    mean: float
    sd: float


@dataclass(frozen=True)
class Pad:
    """Electrode pad: an interdigitated comb, or a parallel plate (area = overlap_length x width)."""

    type: Literal["interdigitated", "parallel_plate"] = "interdigitated"
    electrodes: int = 28
    electrode_length: float = 1.5e-3
    electrode_gap: float = 0.5e-3
    film_thickness: float = 24e-6
    overlap_length: float = 55.5e-3


@dataclass(frozen=True)
class CapacitanceFixture:
    """The bench on which capacitance against normal force is read."""

    overlap_length: float = 60e-3
    meter_frequency: float = 1000.0
    stray_capacitance: float = 0.0


@dataclass(frozen=True)
class Substrate:
    """A metal strip: density [kg/m3], mass carried along [kg], length [m], thickness by width [m: m]."""

    density: float = 8049.0
    extra_mass: float = 0.0
    length: float = 0.1
    thickness: Mapping[float, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Friction:
    """Friction coefficients of the substrate with the base and with the film (dimensionless)."""

    base_static: Gaussian = Gaussian(0.281, 0.034)
    base_kinetic: Gaussian = Gaussian(0.173, 0.008)
    film_static: Gaussian = Gaussian(0.188, 0.010)
    film_kinetic: Gaussian = Gaussian(0.154, 0.008)

    @property
    def sliding(self) -> float:
        """Friction on both faces of a sliding strip, per newton of preload."""
        return self.base_kinetic.mean + self.film_kinetic.mean


@dataclass(frozen=True)
class LoadCell:
    """Priors of the load cell's stiffness [N/m], effective mass [kg] and damping [kg/s]."""

    stiffness: Gaussian = Gaussian(18018.0, 500.0)
    mass: Gaussian = Gaussian(0.0011004, 0.00005)
    damping: Gaussian = Gaussian(0.4274, 0.05)


@dataclass(frozen=True)
class Drive:
    """High-voltage drive: 10-90 % rise and 90-10 % fall times [s]."""

    rise_10_90: float = 8.3e-6
    fall_90_10: float = 5.2e-6


@dataclass(frozen=True)
class SessionSpan:
    """A named session: all runs stamped within [start, end], both inclusive."""

    name: str
    start: datetime
    end: datetime


@dataclass(frozen=True)
class Bench:
    """The facts of campaign.yaml in SI units (contract: A campaign)."""

    name: str
    pad: Pad = Pad()
    film_density: float = 1780.0
    fixture: CapacitanceFixture = CapacitanceFixture()
    substrates: Mapping[str, Substrate] = field(default_factory=dict)
    friction: Friction = Friction()
    load_cell: LoadCell = LoadCell()
    drive: Drive = Drive()
    stage_speed: float = 0.5e-3
    sessions: tuple[SessionSpan, ...] | None = None  # None: by date
    exclude: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class RunSettings:
    """What a log's name says of the run, in SI. ``preload`` is None where the name says -1 g."""

    run: str
    stamp: datetime
    travel: float
    speed: float
    preload: float | None
    voltage: float
    frequency: float
    width: float
    substrate: str


@dataclass(frozen=True)
class LogFile:
    """One log of a campaign: its settings and where it lies."""

    settings: RunSettings
    path: Path


@dataclass(frozen=True)
class Campaign:
    """A campaign folder, listed and checked; nothing in it has been parsed but campaign.yaml and names."""

    folder: Path
    bench: Bench
    logs: tuple[LogFile, ...]
    capacitance_files: tuple[Path, ...]
    permittivity_files: tuple[Path, ...]
    load_cell_files: tuple[Path, ...]


@dataclass(frozen=True)
class Recording:
    """One run's four columns as logged (or repaired), each of shape (samples,).

    time [s], force [N], flag (1 while the high voltage is enabled), voltage [V] (sensed electrode).
    ``flags`` names what was found or done (stable words, see rig/quality).
    """

    settings: RunSettings
    time: FloatArray
    force: FloatArray
    flag: FloatArray
    voltage: FloatArray
    flags: tuple[str, ...] = ()


@dataclass(frozen=True)
class RunConditions:
    """What a model needs to know of each run to predict it; every array has shape (runs,).

    voltage [V], frequency [Hz] (0.1 = DC), width, thickness [m], friction_before [N] (measured, less the
    zero; gives the preload), switch_off_force [N] (measured, less the zero: the median of the last 3 ms; where the
    stage still moved, the load train stands higher when the voltage falls; NaN = let the model's own stick-slip
    decide), drive_duration [s] (voltage on to off),
    dwell [s] (rest before the voltage falls: the stage already stands), run_order (0.. in the session),
    session, condition, run, substrate: names; session_number (0.. in order of the first run of each session,
    filled in where it is not given, and kept by ``select``: a part of a campaign numbers them as the whole does).
    """

    run: tuple[str, ...]
    session: tuple[str, ...]
    condition: tuple[str, ...]
    substrate: tuple[str, ...]
    voltage: FloatArray
    frequency: FloatArray
    width: FloatArray
    thickness: FloatArray
    friction_before: FloatArray
    switch_off_force: FloatArray
    drive_duration: FloatArray
    dwell: FloatArray
    run_order: FloatArray
    session_number: FloatArray | None = None

    ARRAYS = ("voltage", "frequency", "width", "thickness", "friction_before", "switch_off_force",
              "drive_duration", "dwell", "run_order", "session_number")  # fmt: skip
    NAMES = ("run", "session", "condition", "substrate")

    def __post_init__(self) -> None:
        n = len(self.run)
        if self.session_number is None:
            numbers = {name: number for number, name in enumerate(dict.fromkeys(self.session))}
            object.__setattr__(self, "session_number", np.array([numbers[name] for name in self.session]))
        for name in self.ARRAYS:
            array = np.asarray(getattr(self, name), dtype=float)
            if array.shape != (n,):
                raise ValueError(f"{name} has shape {array.shape}, expected ({n},)")
            object.__setattr__(self, name, array)
        for name in self.NAMES:
            if len(getattr(self, name)) != n:
                raise ValueError(f"{name} has {len(getattr(self, name))} entries, expected {n}")

    def __len__(self) -> int:
        return len(self.run)

    def select(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> RunConditions:
        """The runs at ``rows`` (indices or a mask), in that order."""
        rows = np.arange(len(self))[rows]
        parts: dict = {name: getattr(self, name)[rows] for name in self.ARRAYS}
        parts |= {name: tuple(getattr(self, name)[i] for i in rows) for name in self.NAMES}
        return replace(self, **parts)


@dataclass(frozen=True)
class ObservableInfo:
    """What an observable is, apart from how it is extracted. ``resolution`` (unit of the observable): the
    smallest change of the truth that the rig can tell, None where the standard uncertainty says it all."""

    name: str
    unit: str
    phase: str
    definition: str
    resolution: float | None = None


@dataclass(frozen=True)
class Spectrum:
    """Real relative permittivity of one source: frequency [Hz] and permittivity, both (points,)."""

    source: str
    frequency: FloatArray
    permittivity: FloatArray


@dataclass(frozen=True)
class CapacitanceReadings:
    """Raw bench readings, each (readings,): force [N], capacitance [F], width [m], trial (labels)."""

    force: FloatArray
    capacitance: FloatArray
    width: FloatArray
    trial: tuple[str, ...]
    source: tuple[str, ...]


@dataclass(frozen=True)
class BurstFeatures:
    """Free swings of the bare load cell, each (bursts,): frequency [Hz], damping ratio, their sds."""

    frequency: FloatArray
    frequency_sd: FloatArray
    damping_ratio: FloatArray
    damping_ratio_sd: FloatArray


@dataclass(frozen=True)
class FieldSolution:
    """A solved electrostatic cross-section. ``pressure`` [Pa]: force on the substrate over the electrodes' area;
    ``gap_voltage`` [V]: mean |potential difference| across the air gap above the electrodes;
    ``substrate_potential`` [V] (conductor only, else NaN); x [m], y [m], potential [V]: the nodes."""

    pressure: float
    gap_voltage: float
    substrate_potential: float
    x: FloatArray
    y: FloatArray
    potential: FloatArray
