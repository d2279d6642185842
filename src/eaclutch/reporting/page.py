"""The report: one self-contained page, verdict first."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from eaclutch.provenance import commit, versions
from eaclutch.reporting import sentences
from eaclutch.reporting.bench_figures import bench_figures
from eaclutch.reporting.diagnosis_figures import (
    by_observable_figure,
    closure_figure,
    hypotheses_figure,
)
from eaclutch.reporting.drawing import Picture
from eaclutch.reporting.glance import glance, glossary, missing_table
from eaclutch.reporting.posterior_figures import corner_figure, trace_figure
from eaclutch.reporting.prediction_figures import coverage_figure, prediction_figures
from eaclutch.reporting.results import STAGES, Results
from eaclutch.reporting.templating import environment, style
from eaclutch.reporting.thumbnails import HEIGHT, WIDTH, Thumbnail, thumbnails
from eaclutch.reporting.where_figures import where_figures
from eaclutch.reporting.words import (
    Scale,
    measured,
    number,
    scale_for,
)


@dataclass(frozen=True)
class ParameterRow:
    """A calibrated parameter as the table shows it."""

    stage: str
    name: str
    value: str
    unit: str
    r_hat: str
    effective: str
    prior_sd: str
    converged: bool | None
    source: str


def render(results: Results, config: Mapping[str, Any]) -> str:
    """The page as HTML; all text from the campaign is escaped."""
    diagnosis, shown = results.diagnosis, thumbnails(results)
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            style=style(),
            results=results,
            diagnosis=diagnosis,
            sentence=sentences.verdict_sentence(diagnosis),
            glance=glance(results),
            missing=missing_table(results),
            glossary=glossary(results),
            caveats=sentences.caveats(results),
            where=sentences.where_sentences(diagnosis),
            absorbed=sentences.absorption_sentences(diagnosis),
            level=_level(diagnosis),
            gap_pictures=_some(
                closure_figure(diagnosis), hypotheses_figure(diagnosis), by_observable_figure(results)
            ),
            where_pictures=where_figures(results),
            predictions=_some(*prediction_figures(results), coverage_figure(results)),
            parameters=_parameters(results.summary),
            corners=_some(*(corner_figure(stage, draws) for stage, draws in results.draws.items())),
            traces=_some(*(trace_figure(stage, draws) for stage, draws in results.draws.items())),
            stage_notes={stage: draws.notes for stage, draws in results.draws.items() if draws.notes},
            benches=bench_figures(results),
            thumbnails=shown,
            thumbnail_size=(WIDTH, HEIGHT),
            unused=_unused(shown),
            config=json.dumps(
                {**config, "campaign": Path(config.get("campaign", results.name)).name},
                indent=1,
                sort_keys=True,
            ),
            versions=versions(),
            commit=commit(),
            seed=config.get("seed"),
        )
    )


def _level(diagnosis: Mapping[str, Any]) -> str:
    """none, unknown, tied or named: how the verdict is marked."""
    verdict = diagnosis["verdict"]
    if not verdict["effects"]:
        return "tied" if verdict.get("alternatives") else "none"
    if verdict["effects"] == ["unknown"]:
        return "unknown"
    return "tied" if verdict.get("alternatives") else "named"


def _some(*pictures: Picture | None) -> list[Picture]:
    return [item for item in pictures if item is not None]


def _parameters(summary: Mapping[str, Any]) -> list[ParameterRow]:
    rows = []
    for stage in (stage for stage in STAGES if stage in summary):
        part = summary[stage]
        for name, entry in part.get("parameters", {}).items():
            scale = scale_for([entry.get("median") or np.nan], entry.get("unit") or "1")
            median, low, high, prior_sd = (
                _times(entry.get(key), scale) for key in ("median", "q05", "q95", "prior_sd")
            )
            rows.append(
                ParameterRow(
                    stage=stage.replace("_", " "),
                    name=name.replace("_", " "),
                    value=measured(median, low, high),
                    unit=scale.unit or "1",
                    r_hat=number(entry.get("r_hat"), 4),
                    effective=number(entry.get("ess_bulk"), 3),
                    prior_sd=number(prior_sd),
                    converged=part.get("converged"),
                    source=part.get("source", ""),
                )
            )
    return rows


def _times(value: float | None, scale: Scale) -> float | None:
    return None if value is None else float(scale(value))


def _unused(shown: list[Thumbnail]) -> list[tuple[str, str]]:
    """Runs that are not used, and why."""
    return [(item.run, item.why) for item in shown if not item.usable]
