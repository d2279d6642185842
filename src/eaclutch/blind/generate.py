"""The two things that leave the generator: what the diagnosing side may see, and the answer, kept apart."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from eaclutch.blind.bench_readings import draw_bursts, draw_capacitance, draw_spectra
from eaclutch.blind.case import Case, build_case, campaign_yaml
from eaclutch.blind.observe import runs_table
from eaclutch.blind.plan import Entry, generator
from eaclutch.blind.truth import truth_of
from eaclutch.files import write_csv, write_text
from eaclutch.records import BurstFeatures, CapacitanceReadings, Spectrum


@dataclass(frozen=True)
class Tables:
    """What may be seen of a case at observable level. ``campaign``: the content of campaign.yaml."""

    name: str
    campaign: dict[str, Any]
    runs: pd.DataFrame
    capacitance: CapacitanceReadings
    spectra: tuple[Spectrum, ...]
    bursts: BurstFeatures


def tables_of(case: Case) -> Tables:
    """Read a case off its own bench: noisy tables, nothing of the truth."""

    def stream(purpose: str) -> np.random.Generator:
        return generator(case.entry.namespace, case.entry.seed, purpose)

    return Tables(
        name=case.entry.case,
        campaign=campaign_yaml(case),
        runs=runs_table(case),
        capacitance=draw_capacitance(case.constants, stream("capacitance")),
        spectra=draw_spectra(case.constants, stream("spectra")),
        bursts=draw_bursts(case.constants, stream("bursts")),
    )


def generate_case(entry: Entry) -> tuple[Tables, dict[str, Any]]:
    """A case at observable level and, apart from it, the answer (see ``answer_of``)."""
    case = build_case(entry)
    return tables_of(case), answer_of(case)


def answer_of(case: Case, *, truth: bool = False) -> dict[str, Any]:
    """What a diagnosis should find: effects with sizes, the right verdict, the true constants of the bench.

    ``truth`` adds distances, closures and places (``truth_of``; some seconds).
    """
    entry, c = case.entry, case.constants
    named = sorted(name for name, _ in entry.effects)
    return {
        "schema": 1,
        "case": entry.case,
        "kind": entry.kind,
        "effects": [{"effect": name, "size": size} for name, size in sorted(entry.effects)],
        "verdict": ["unknown"] if entry.kind == "unknown" else named,
        "misfit": {"law": entry.misfit_law, "share": entry.misfit},
        "parameters": {
            "contact_stiffness": c.contact_stiffness,
            "roughness_sd": c.roughness_sd,
            "film_thickness": c.film_thickness,
            "kappa_static": c.kappa_static,
            "kappa_infinity": c.kappa_infinity,
            "relaxation_time": c.relaxation_time,
            "cole_cole_exponent": c.cole_cole_exponent,
            "stiffness": c.stiffness,
            "mass": c.mass,
            "damping": c.damping,
            "base_static": c.base_static,
            "base_kinetic": c.base_kinetic,
            "film_static": c.film_static,
            "film_kinetic": c.film_kinetic,
        },
        "seed": {"namespace": entry.namespace, "seed": entry.seed},
    } | ({"truth": truth_of(case)} if truth else {})


def write_bench(tables: Tables, folder: Path) -> None:
    """campaign.yaml, capacitance/ and permittivity/ of a campaign folder."""
    text = yaml.safe_dump(tables.campaign, sort_keys=False, default_flow_style=None)
    write_text(folder / "campaign.yaml", text)
    readings = tables.capacitance
    frame = {
        "force_n": readings.force,
        "capacitance_pf": readings.capacitance * 1e12,
        "width_mm": readings.width * 1e3,
        "trial": list(readings.trial),
    }
    write_csv(folder / "capacitance" / "capacitance.csv", pd.DataFrame(frame))
    for spectrum in tables.spectra:
        points = {"frequency_hz": spectrum.frequency, "relative_permittivity": spectrum.permittivity}
        write_csv(folder / "permittivity" / f"{spectrum.source}.csv", pd.DataFrame(points))


def write_tables(tables: Tables, folder: Path) -> None:
    """A case at observable level: the bench's files, runs.csv and bursts.csv beside them."""
    write_bench(tables, folder)
    write_csv(folder / "runs.csv", tables.runs)
    bursts = tables.bursts
    write_csv(
        folder / "bursts.csv",
        pd.DataFrame(
            {
                "frequency_hz": bursts.frequency,
                "frequency_hz_sd": bursts.frequency_sd,
                "damping_ratio": bursts.damping_ratio,
                "damping_ratio_sd": bursts.damping_ratio_sd,
            }
        ),
    )
