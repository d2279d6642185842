"""Design maps, the paper's numbers, and the finite-element check."""

from __future__ import annotations

import logging
from pathlib import Path

import click

from eaclutch.config.slices import parse_settings
from eaclutch.files import read_table, write_csv, write_text

_FOLDER = click.Path(file_okay=False, path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)
_settings = click.option("--settings", required=True, help="The config's parts as JSON.")
_page = click.option("--page", type=_FILE, required=True, help="The page to write.")


@click.command("fea")
@click.option("--campaign", type=_FOLDER, required=True, help="The campaign whose pad is solved.")
@click.option("--voltage", type=float, default=300.0, show_default=True, help="Applied voltage [V].")
@click.option("--table", type=_FILE, required=True, help="Pressures by both ways to write (csv).")
@click.option("--insulators", type=_FILE, required=True, help="Insulating substrates to write (csv).")
@_page
def fea(campaign: Path, voltage: float, table: Path, insulators: Path, page: Path) -> None:
    """Finite elements against the analytic pressure, and insulating substrates."""
    from eaclutch.config import load_bench
    from eaclutch.reporting.field_page import field_page
    from eaclutch.studies.field_study import EXAMPLE_GAP, conductor_table, example_fields, insulator_table

    logging.getLogger("skfem").setLevel(logging.WARNING)  # it reports every assembly
    pad = load_bench(campaign).pad
    conductor, insulator = conductor_table(pad, voltage), insulator_table(pad, voltage)
    write_csv(table, conductor)
    write_csv(insulators, insulator)
    fields = example_fields(pad, voltage)
    write_text(page, field_page(conductor, insulator, fields, pad.film_thickness, EXAMPLE_GAP, voltage))


@click.command("sweep")
@click.option("--campaign", type=_FOLDER, required=True, help="The campaign whose bench is varied.")
@click.option("--results", type=_FOLDER, required=True, help="Its results, for the posteriors.")
@_settings
@click.option("--table", type=_FILE, required=True, help="All maps to write (csv).")
@_page
def sweep(campaign: Path, results: Path, settings: str, table: Path, page: Path) -> None:
    """Design maps with the posterior's band, and the probability of meeting limits."""
    from eaclutch.config import load_bench
    from eaclutch.inference.draws import load_draws
    from eaclutch.reporting.map_page import map_page
    from eaclutch.studies.map_trends import map_trends
    from eaclutch.studies.maps import design_levels, draw_maps, limits_of, maps_table

    config = parse_settings(settings)
    bench = load_bench(campaign)
    stages = sorted((results / "posterior").glob("*.nc"))
    draws = load_draws(stages, config["sweep"]["draws"])
    maps = draw_maps(bench, config, draws)
    write_csv(table, maps_table(maps, config["sweep"]))
    asked = config["sweep"]
    drawn = [(entry.pad, entry.map) for entry in maps]
    trends = map_trends(
        [entry.map for entry in maps if entry.pad == "interdigitated"], design_levels(bench, asked["design"])
    )
    write_text(page, map_page(drawn, limits_of(asked), asked["limits"], asked["design"], bench.name, trends))


@click.command("paper")
@click.option("--campaign", type=_FOLDER, required=True, help="The campaign whose numbers are compared.")
@click.option("--results", type=_FOLDER, required=True, help="Its results.")
@_settings
@click.option("--table", type=_FILE, required=True, help="All numbers to write (csv).")
@_page
def paper(campaign: Path, results: Path, settings: str, table: Path, page: Path) -> None:
    """The paper's numbers, ours beside them."""
    import numpy as np

    from eaclutch.config import load_bench
    from eaclutch.files import read_json
    from eaclutch.reporting.paper_page import PaperFigures, paper_page
    from eaclutch.rig.table import conditions_from_runs
    from eaclutch.studies import paper as study
    from eaclutch.studies.claims import LITERATURE_TIMES, claims_table, side_claims
    from eaclutch.studies.maps import model_of
    from eaclutch.studies.sweep import Design
    from eaclutch.studies.trends import bandwidth, force_exponents, release_by_frequency

    bench, config = load_bench(campaign), parse_settings(settings)
    runs = read_table(results / "runs.csv")
    published = read_table(results / "runs_published.csv")
    model = model_of(bench, config["model"])
    parameters = study.medians(read_json(results / "posterior" / "summary.json"), model)
    usable = runs[runs["usable"] & runs["release_time_90_s"].notna()]
    design = Design(sorted(bench.substrates)[0])
    curves = study.DesignCurves(model, parameters, design)
    groups = {
        "From the recordings": study.run_claims(runs, published),
        "From the calibrated model": study.model_claims(curves),
        "With the paper's parameters": study.preset_claims(bench, design.start_ratio),
        "Side computations": side_claims(),
    }
    write_csv(table, claims_table(groups))
    figures = PaperFigures(
        force_exponents=force_exponents(study.largest_forces(runs, published)),
        capacity_exponents=force_exponents(runs),
        release=release_by_frequency(runs),
        multiplier=study.multiplier_table(model, conditions_from_runs(usable, bench), parameters),
        bandwidth=study.force_over_frequency(curves),
        corner=bandwidth(curves.largest_force),
        step=study.step_response(np.geomspace(1e-7, 1e-2, 101)),
    )
    write_text(page, paper_page(groups, figures, LITERATURE_TIMES, bench.name))


COMMANDS: list[click.Command] = [fea, sweep, paper]
