"""One campaign made ready for diagnosis: its data vector, its models, and what a residual may be without being an
effect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from eaclutch.diagnosis import bench_channels
from eaclutch.diagnosis.carried import carried
from eaclutch.diagnosis.cells import Cells, cells_of, native_variances, repeat_variance
from eaclutch.diagnosis.channels import channels_on
from eaclutch.diagnosis.condense import condense
from eaclutch.diagnosis.covariance import Kernels, kernels
from eaclutch.diagnosis.data import DataVector
from eaclutch.diagnosis.entries import build
from eaclutch.diagnosis.fit import fit_hypothesis
from eaclutch.diagnosis.forward import Forward
from eaclutch.diagnosis.free_swing import count_swings
from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.diagnosis.run_settings import estimated_preload
from eaclutch.diagnosis.session_moves import session_moves, with_sessions
from eaclutch.physics.effects import EFFECTS, LOOKALIKES, NAMED
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.prediction import OBSERVABLES
from eaclutch.records import FloatArray, InputError, RunConditions
from eaclutch.rig.table import conditions_from_runs

# Local error of the film's position: 1 us in a release time, half the cost of the default.
SOLVER_TOLERANCE = 1e-3


class PreparedCampaign:
    """What does not hang on any hypothesis; deterministic.

    ``known``: what another job's study of the same inputs says of its own fits; the first fit is made without it.
    """

    def __init__(
        self,
        inputs: DiagnosisInputs,
        thresholds: Mapping[str, Any],
        known: Mapping[str, Any] | None = None,
    ):
        self.inputs, self.thresholds = inputs, thresholds
        self.priors = {**thresholds["priors"], **(inputs.priors or {})}
        for name in inputs.candidates:
            if name in LOOKALIKES:
                raise InputError(
                    f"diagnosis.candidates, {name}",
                    "is a lookalike, which is always weighed and never named",
                    "leave it out, or switch it on in model.effects",
                )
        every = inputs.candidates or NAMED
        self.candidates = tuple(name for name in every if name not in inputs.effects)
        self.lookalikes = tuple(name for name in LOOKALIKES if name not in inputs.effects)
        usable = conditions_from_runs(inputs.table, inputs.bench).run
        if len(usable) == 0:
            raise InputError(
                "runs.csv", "no usable run", "look at its flags and reasons; nothing can be diagnosed"
            )
        channels = [
            c
            for c in channels_on(inputs.bench)
            if c.resolvable and c.name in inputs.table and c.name in OBSERVABLES
        ]
        table = inputs.table[inputs.table["run"].isin(usable)].reset_index(drop=True)
        self.table, self.condensed = condense(table, len(channels))
        self.conditions: RunConditions = conditions_from_runs(self.table, inputs.bench)
        widths = [w for substrate in inputs.bench.substrates.values() for w in substrate.thickness]
        entries = bench_channels.summarise(inputs.readings, inputs.spectra, inputs.bursts, thresholds, widths)
        preload = estimated_preload(self.table, self.conditions, inputs.bench.friction)
        cell = inputs.bench.load_cell
        rate = cell.stiffness.mean * inputs.bench.stage_speed
        quarter = 0.5 * np.pi * np.sqrt(cell.mass.mean / cell.stiffness.mean)

        def data(*explained: FloatArray) -> DataVector:
            return build(
                self.table, self.conditions, entries, channels, thresholds, preload, rate, quarter, *explained
            )

        first = data()
        self.known = known
        self.first_fit: dict[str, float] = {} if known is None else dict(known["first_fit"])
        if first.run_entries:
            channels = list(first.channels)
            first = data(*self._explained(first))
        self.data = first
        if self.data.run_entries == 0:
            raise InputError("runs.csv", "no observable can be compared", "look at its flags and reasons")
        moves = session_moves(self.forward(()), self.first_fit, thresholds["session_together"])
        self.kernels: Kernels = with_sessions(kernels(self.data, thresholds), self.data.session, moves)
        variances, self.dof = native_variances(self.table, self.data, thresholds)
        self.cells: Cells = cells_of(self.data, variances)
        self.repeat_variance = repeat_variance(self.data, variances)
        self.swings = count_swings(self.table)

    def model(self, effects: Sequence[str] = ()) -> ClutchModel:
        """The campaign's model with ``effects`` on top, in the library's order."""
        chosen = set(self.inputs.effects) | set(effects)
        names = tuple(name for name in EFFECTS if name in chosen)
        return ClutchModel(
            self.inputs.bench, names, tolerance=SOLVER_TOLERANCE, **(self.inputs.model_options or {})
        )

    def _explained(self, first: DataVector) -> tuple[FloatArray, FloatArray]:
        """Run-level predictions of the base model after a first fit, and what they are uncertain by, (channels, runs)
        each."""
        forward = Forward(self.model(), first, (), self.priors)
        if self.known is None:
            fitted = fit_hypothesis(forward, first, kernels(first, self.thresholds), self.thresholds)
            self.first_fit = fitted.parameters
        else:
            in_order(self.first_fit, forward)
        return carried(forward, self.table, self.first_fit)

    def forward(self, effects: Sequence[str], *, contact_law: bool = False) -> Forward:
        """Predictions with ``effects`` on top; ``contact_law``: whether the contact law may bend."""
        return Forward(self.model(effects), self.data, effects, self.priors, contact_law)


def in_order(named: Mapping[str, float], forward: Forward) -> FloatArray:
    """Values (params,) in the order of ``forward``'s parameters. Raises InputError where they are not the same."""
    names = forward.priors.names
    if set(named) != set(names):
        raise InputError("gap.json", "is of another model or campaign", "run diagnosis-gap again")
    return np.array([named[name] for name in names])
