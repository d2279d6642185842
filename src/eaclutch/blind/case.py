"""One case: a bench, its runs, and what was done to them; and how it is made from a plan's entry."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from eaclutch.blind.candidates import NAMED
from eaclutch.blind.clutch import Motion, move
from eaclutch.blind.design import DC, Design, draw_design
from eaclutch.blind.plan import Entry, generator
from eaclutch.blind.readout import Disturbance, draw_disturbances
from eaclutch.blind.strangers import UNNAMED
from eaclutch.blind.world import Constants, Runs, draw_constants, real_permittivity
from eaclutch.records import FloatArray

# Scatter of the rig, relative: from run to run and from session to session (published repeats: capacity about
# 5 %, release 3-8 %).
RUN_SCATTER = {"pull": 0.02, "rub": 0.025, "preload": 0.12, "squeeze": 0.12}
SESSION_SCATTER = {"pull": 0.02, "rub": 0.015}


@dataclass(frozen=True)
class Case:
    """The truth of one campaign: everything that tables and logs are read from."""

    entry: Entry
    design: Design
    constants: Constants
    runs: Runs
    motion: Motion
    disturbances: tuple[Disturbance, ...]
    free_start: FloatArray  # s before the tip meets the substrate; 0 where a run begins in contact


def clean_state(design: Design, c: Constants, rng: np.random.Generator) -> Runs:
    """The runs without any effect: settings, preloads that drift, and the scatter of pull, friction and film."""
    n, sessions = len(design.order), design.session.astype(int)
    count = len(design.session_names)

    def scatter(name: str) -> np.ndarray:
        per_session = rng.normal(0, SESSION_SCATTER.get(name, 0.0), count)[sessions]
        return np.exp(per_session + rng.normal(0, RUN_SCATTER[name], n))

    half = np.where(design.frequency > DC, np.minimum(0.5 / design.frequency, 0.5), 0.0)
    wander = np.exp(0.15 * np.sin(2 * np.pi * (design.order / 30 + rng.random(count)[sessions])))
    kappa = real_permittivity(
        np.where(design.frequency > DC, design.frequency, 1e-3),
        c.kappa_static,
        c.kappa_infinity,
        c.relaxation_time,
        c.cole_cole_exponent,
    )
    rub = scatter("rub")
    return Runs(
        voltage=design.voltage,
        frequency=design.frequency,
        width=design.width,
        thickness=design.thickness,
        preload=design.preload_target * wander * scatter("preload"),
        drive_time=3.0 + half,
        dwell=half,
        order=design.order,
        session=design.session,
        kappa=kappa,
        film_thickness=np.full(n, c.film_thickness),
        base_static=c.base_static * rub,
        base_kinetic=np.full(n, c.base_kinetic),
        film_static=c.film_static * rub,
        film_kinetic=np.full(n, c.film_kinetic),
        knobs={"force_factor": scatter("pull"), "squeeze_factor": scatter("squeeze")},
    )


def build_case(entry: Entry, *, leave_out: tuple[str, ...] = ()) -> Case:
    """Make a case from its plan entry; the same entry gives the same case, bit for bit.

    ``leave_out`` names effects that are not applied though everything else, all scatter included, stays: the
    counterfactual from which the true share of each effect is measured.
    """

    def stream(purpose: str) -> np.random.Generator:
        return generator(entry.namespace, entry.seed, purpose)

    design = draw_design(stream("design"))
    c = draw_constants(stream("constants"))
    runs = clean_state(design, c, stream("scatter"))
    if "misfit" not in leave_out:
        c = replace(c, law=entry.misfit_law, law_share=entry.misfit)
    laws = NAMED | UNNAMED
    for name, size in entry.effects:
        if name not in leave_out:
            runs, c = laws[name](runs, c, size, stream(f"effect {name}"))
    return Case(
        entry=entry,
        design=design,
        constants=c,
        runs=runs,
        motion=move(runs, c, stream("slips")),
        disturbances=draw_disturbances(len(design.session_names), stream("disturbances")),
        free_start=draw_free_starts(design, stream("starts")),
    )


def draw_free_starts(design: Design, rng: np.random.Generator) -> FloatArray:
    """How long each run goes without contact [s]: often in one session, rarely in the others (as published)."""
    share = np.where(design.session == rng.integers(0, 3), 0.8, 0.08)
    free = rng.random(len(share)) < share
    return np.where(free, rng.uniform(0.05, 0.3, len(share)), 0.0)


def campaign_yaml(case: Case) -> dict[str, Any]:
    """The case's campaign.yaml as a plain dictionary: the published bench, and nothing of the truth."""
    thickness = {f"{w:g}": t for w, t in ((2, 2), (2.5, 2.5), (3, 3), (4, 2), (5, 2.5), (6, 3))}
    return {
        "name": case.entry.case,
        "substrates": {
            "brass": {
                "density_kg_m3": 8338.5,
                "extra_mass_kg": 0.000726,
                "length_mm": 100,
                "thickness_mm": {float(w): t for w, t in thickness.items()},
            }
        },
        "sessions": "by_date",
    }
