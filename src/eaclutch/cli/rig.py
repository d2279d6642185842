"""Commands of the rig room: from recordings to tables of observables."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd

from eaclutch.config import load_bench
from eaclutch.config.slices import parse_settings
from eaclutch.files import atomic, read_json, read_table, write_csv, write_json
from eaclutch.manifest import batch_runs
from eaclutch.records import Bench, InputError
from eaclutch.rig import published as published_definitions
from eaclutch.rig.batch import extract_batch, join_batches
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.capacitance import read_capacitance
from eaclutch.rig.gap import gap_table
from eaclutch.rig.inspection import inspect as look_at
from eaclutch.rig.load_cell import read_bursts
from eaclutch.rig.logs import read_log
from eaclutch.rig.spectra import read_spectra
from eaclutch.rig.table import PRELOAD_EDGES, observable_infos

_FILE = click.Path(dir_okay=False, path_type=Path)
_campaign = click.option(
    "--campaign", type=click.Path(path_type=Path), required=True, help="Folder of recordings."
)
_settings = click.option("--settings", default="{}", help="Slice of the config, as JSON.")


def _output(name: str, what: str) -> Any:
    return click.option(name, type=_FILE, required=True, help=f"{what} to write.")


@click.command("observables")
@_campaign
@click.option("--capture", type=_FILE, required=True, help="capture.json, which says what each batch holds.")
@click.option("--batch", type=int, required=True, help="Which batch of runs.")
@_output("--output", "Table of the batch's observables")
@_output("--published", "Table of the batch's values by the published definitions")
@_output("--traces", "Thinned forces of the batch's runs (.npz)")
def observables(
    campaign: Path, capture: Path, batch: int, output: Path, published: Path, traces: Path
) -> None:
    """Extract the observables of a batch of runs."""
    paths = [campaign / path for _, path in sorted(batch_runs(read_json(capture), batch).items())]
    found = extract_batch(paths, load_bench(campaign))
    write_csv(output, pd.DataFrame(found.runs))
    write_csv(published, pd.DataFrame(found.published, columns=published_definitions.COLUMNS))
    _write_arrays(traces, found.traces)


@click.command("runs")
@_campaign
@_settings
@_output("--output", "runs.csv")
@_output("--published", "runs_published.csv")
@_output("--definitions", "observables.json")
@_output("--quality", "quality.json")
@click.argument("tables", nargs=-1, required=True, type=_FILE)
def runs(
    campaign: Path,
    settings: str,
    output: Path,
    published: Path,
    definitions: Path,
    quality: Path,
    tables: tuple[Path, ...],
) -> None:
    """Join the batches' TABLES (those named published* apart) to the campaign's."""
    chosen, bench = parse_settings(settings), load_bench(campaign)
    bench = replace(bench, exclude={**bench.exclude, **chosen.get("observables.exclude", {})})
    apart = [path for path in tables if path.name.startswith("published")]
    edges = chosen.get("observables.preload_bin_edges_n", PRELOAD_EDGES)
    table, counts = join_batches([read_table(path) for path in tables if path not in apart], bench, edges)
    write_csv(output, table)
    by_definition = pd.concat([read_table(path) for path in apart], ignore_index=True)
    write_csv(published, by_definition.sort_values("run", ignore_index=True))
    write_json(definitions, observable_infos())
    write_json(quality, counts)


@click.command("gap")
@_campaign
@_settings
@_output("--gap", "gap.csv")
@_output("--spectra", "spectra.csv")
@_output("--bursts", "bursts.csv")
def gap(campaign: Path, settings: str, gap: Path, spectra: Path, bursts: Path) -> None:
    """Capacitance readings as gaps, permittivity spectra, free swings of the bare load cell."""
    opened, chosen = open_campaign(campaign), parse_settings(settings)
    widths = [width * 1e-3 for width in chosen.get("posterior.capacitance_widths_mm", ())]
    force_max = chosen.get("posterior.capacitance_force_max_n", np.inf)
    readings = gap_table(read_capacitance(opened), opened.bench, widths=widths, force_max=force_max)
    write_csv(gap, pd.DataFrame(readings))
    points = [
        (spectrum.source, frequency, permittivity)
        for spectrum in read_spectra(opened)
        for frequency, permittivity in zip(spectrum.frequency, spectrum.permittivity, strict=True)
    ]
    write_csv(spectra, pd.DataFrame(points, columns=["source", "frequency_hz", "relative_permittivity"]))
    found = read_bursts(opened)
    columns = {"frequency_hz": found.frequency, "frequency_hz_sd": found.frequency_sd}
    columns |= {"damping_ratio": found.damping_ratio, "damping_ratio_sd": found.damping_ratio_sd}
    write_csv(bursts, pd.DataFrame(columns))


@click.command("inspect")
@click.argument("log", type=click.Path(path_type=Path))
@click.option(
    "--campaign",
    type=click.Path(path_type=Path),
    help="Folder with campaign.yaml; default: two above the log.",
)
@click.option(
    "--output",
    type=_FILE,
    help="Picture to write (.png, .svg, .pdf); default: the run's name in this folder.",
)
def inspect(log: Path, campaign: Path | None, output: Path | None) -> None:
    """One picture and one table of a run: phases, events, observables with uncertainty, flags."""
    from eaclutch.reporting.run_figure import run_figure

    folder = campaign or log.resolve().parent.parent
    known = campaign is not None or (folder / "campaign.yaml").is_file()
    bench = load_bench(folder) if known else Bench(name="inspect")
    seen = look_at(read_log(log), bench)
    click.echo(seen.table)
    output = output or Path(f"{seen.recording.settings.run}.png")
    if output.suffix not in (".png", ".svg", ".pdf"):
        raise InputError(output, "is no picture's name", "end it in .png, .svg or .pdf")
    with atomic(output) as temporary:
        run_figure(seen.recording, seen.instants, seen.values).savefig(temporary, dpi=110)
    click.echo(f"picture {output}")


def _write_arrays(path: Path, arrays: dict[str, Any]) -> None:
    with atomic(path) as temporary, Path(temporary).open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, **arrays)


COMMANDS = [observables, runs, gap, inspect]
