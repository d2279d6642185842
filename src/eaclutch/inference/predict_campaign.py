"""predict/runs.csv and coverage.json: every run predicted with and without itself in the fit.

Runs are predicted in blocks, of which only quantiles and ranks are kept, and parts of a campaign in jobs of their own;
what comes out for a run does not depend on how many jobs there are.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from eaclutch.inference.coverage import coverage_document, ranks
from eaclutch.inference.draws import inside, load_draws, with_prior_draws
from eaclutch.inference.left_out import folds, refit_draws, unseen_voltages, without
from eaclutch.inference.posterior import StageInputs, force_response
from eaclutch.inference.prediction import Measured, Predicted, predict_runs, replicate
from eaclutch.inference.response import Response
from eaclutch.physics.model import ClutchModel
from eaclutch.records import FloatArray

COLUMNS = ("run", "observable", "q05", "median", "q95", "measured", "measured_sd", "status", "held_out")
SPLITS = ("in_sample", "left_out_condition", "left_out_session")
ORDER = ["run", "observable", "held_out"]
TOGETHER = 500  # runs that are predicted at once: a model's own arrays are many times what is kept
NINETY = 8  # index of the 90 % level in the calibration curves
logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Fold:
    """Draws {name: (draws,)} of a fit, and which runs it predicts, (runs,) of true and false."""

    split: str
    number: int
    joint: Mapping[str, FloatArray]
    theirs: np.ndarray


@dataclass(frozen=True)
class _Campaign:
    """What all predictions share."""

    model: ClutchModel
    inputs: StageInputs
    measured: Measured
    joint: Mapping[str, FloatArray]
    response: Response | None
    seed: int
    draws: int

    def generator(self, split: str, *numbers: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, 11, SPLITS.index(split) + 1, *numbers])

    def refit(self, gone: set[str], rng: np.random.Generator) -> dict[str, FloatArray]:
        """Force draws without the runs ``gone``; its prior where no run is left."""
        data = self.inputs.capacity
        if data is None or self.response is None:
            return {}
        keep = np.array([run not in gone for run in data.conditions.run])
        form, known = self.inputs.multiplier_form, dict(self.inputs.parameters)
        return refit_draws(without(data, self.response, keep, form, known), self.draws, rng)

    def left_out(self, split: str, labels: Sequence[str], parts: int) -> Iterator[_Fold]:
        """Fits without all runs of some labels each; none where there is one label only."""
        if len(set(labels)) < 2:
            return
        names, runs = np.array(labels), np.array(self.measured.conditions.run)
        for number, group in enumerate(folds(labels, parts, self.generator(split))):
            theirs, rng = np.isin(names, sorted(group)), self.generator(split, number + 1)
            refit = self.refit(set(runs[theirs]), rng)
            if refit and self.inputs.multiplier_form == "per_voltage":
                refit |= unseen_voltages(self.joint, refit, self.draws, rng)
            yield _Fold(split, number, inside({**self.joint, **refit}, self.inputs.parameters), theirs)


def predict_campaign(
    model: ClutchModel,
    inputs: StageInputs,
    measured: Measured,
    *,
    seed: int,
    draws: int,
    parts: int,
    job: tuple[int, int] = (0, 1),
) -> pd.DataFrame:
    """What each run's predictions come to, by split: columns of predict/runs.csv with ``split`` and ``rank``.

    ``inputs.earlier``: all stages' files; ``parts``: into how many the conditions (sessions) are split; ``job``: number
    and count, each takes its share of the runs by name.
    A row a (split, run, observable): from the posterior of all runs, from one that has not seen the run's condition and
    from one that has not seen its session (held_out true for both). ``rank``: share of predictions below the measured.
    """
    if not len(measured.conditions):
        return pd.DataFrame(columns=[*COLUMNS, "split", "rank"])
    rng = np.random.default_rng([seed, 11])
    joint = with_prior_draws(load_draws(inputs.earlier, draws), inputs.parameters, draws, rng)
    response = None
    if inputs.capacity is not None and len(inputs.capacity.capacity):
        stages = [path for path in inputs.earlier if path.stem != "force"]
        response = force_response(replace(inputs, earlier=stages), rng)
    campaign = _Campaign(model, inputs, measured, joint, response, seed, draws)
    whole = _Fold("in_sample", 0, joint, np.ones(len(measured.conditions), dtype=bool))
    fits = [
        whole,
        *campaign.left_out("left_out_condition", measured.conditions.condition, parts),
        *campaign.left_out("left_out_session", measured.conditions.session, parts),
    ]
    scatters, errors = measured.scatters(), measured.errors()
    tables = []
    for number, block in _blocks(measured.conditions.run, *job):
        for fit in fits:
            rows = block[fit.theirs[block]]
            if not len(rows):
                continue
            part = measured.select(rows)
            prediction = predict_runs(model, part.conditions, fit.joint, tuple(part.values))
            own = {name: sd[rows] for name, sd in errors.items()}
            noise = campaign.generator(fit.split, fit.number + 1, number + 1)
            tables.append(_rows(part, replicate(prediction, own, scatters, noise), fit.split))
    if not tables:
        return pd.DataFrame(columns=[*COLUMNS, "split", "rank"])
    return pd.concat(tables, ignore_index=True).sort_values([*ORDER, "split"], ignore_index=True)


def curves_of(ranks_by_split: Mapping[str, Mapping[str, FloatArray]]) -> dict[str, Any]:
    """coverage.json from ranks {split: {observable: (runs,)}}: the calibration curves of the splits."""
    curves = coverage_document(ranks_by_split)
    for name, part in curves.items():
        if part["all"] is not None:
            logger.info(
                "predict: %s, 90 %% intervals cover %.1f %%", name, 100 * part["all"]["covered"][NINETY]
            )
    return curves


def ranks_of(tables: Iterable[pd.DataFrame]) -> dict[str, dict[str, FloatArray]]:
    """Ranks {split: {observable: (runs,)}} of the tables that ``predict_campaign`` made, in the order of SPLITS."""
    found: dict[str, dict[str, list[FloatArray]]] = {}
    for table in tables:
        for (split, name), rows in table.groupby(["split", "observable"], observed=True):
            found.setdefault(str(split), {}).setdefault(str(name), []).append(rows["rank"].to_numpy(float))
    return {
        split: {name: np.concatenate(parts) for name, parts in sorted(found[split].items())}
        for split in SPLITS
        if split in found
    }


def shown(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of predict/runs.csv; left out by session stands in the curves only."""
    return table.loc[table["split"] != "left_out_session", list(COLUMNS)]


def _blocks(names: Sequence[str], job: int, jobs: int) -> list[tuple[int, np.ndarray]]:
    """A job's share of the blocks of TOGETHER runs in the order of their names: (number, rows)."""
    order = np.argsort(np.array(names))
    blocks = [order[i : i + TOGETHER] for i in range(0, len(order), TOGETHER)]
    return [(int(i), blocks[i]) for i in np.array_split(np.arange(len(blocks)), jobs)[job]]


def _rows(measured: Measured, predicted: Predicted, split: str) -> pd.DataFrame:
    """A row a (run, observable) that was measured or can be predicted; quantiles only where most draws have one."""
    tables = []
    for name, values in predicted.replicated.items():
        finite = np.isfinite(values)
        enough = finite.mean(axis=0) > 0.5
        filled = np.where(enough, values, 0.0)
        quantiles = np.where(enough, np.nanquantile(filled, [0.05, 0.5, 0.95], axis=0), np.nan)
        tables.append(
            pd.DataFrame(
                {
                    "run": measured.conditions.run,
                    "observable": name,
                    "q05": quantiles[0],
                    "median": quantiles[1],
                    "q95": quantiles[2],
                    "measured": measured.values[name],
                    "measured_sd": measured.sds[name],
                    "status": predicted.status[name],
                    "held_out": split != "in_sample",
                    "split": split,
                    "rank": ranks(values, measured.values[name]),
                }
            )
        )
    return pd.concat(tables, ignore_index=True)
