"""Commands of the rig room: from a campaign's folder to tables of observables."""

from __future__ import annotations

from pathlib import Path

import click
import pandas as pd

from eaclutch.files import write_csv, write_json
from eaclutch.rig.batch import batch_of, extract_campaign, join_batches
from eaclutch.rig.campaign import list_campaign, open_campaign
from eaclutch.rig.capacitance import left_out, read_capacitance
from eaclutch.rig.gap import gap_table
from eaclutch.rig.load_cell import read_bursts
from eaclutch.rig.spectra import read_spectra
from eaclutch.rig.table import PRELOAD_EDGES, observable_infos

_FOLDER = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)
_campaign = click.argument("campaign", type=_FOLDER)
_out = click.option("--out", type=_FILE, required=True, help="File to write.")


@click.command("check")
@_campaign
@_out
def check(campaign: Path, out: Path) -> None:
    """List a campaign with checksums (capture.json)."""
    opened = open_campaign(campaign)
    write_json(out, list_campaign(opened) | {"capacitance_left_out": left_out(opened)})


@click.command("extract")
@_campaign
@click.option("--batch", type=int, default=0, show_default=True, help="Which batch of runs.")
@click.option("--batches", type=int, default=1, show_default=True, help="Into how many the runs are split.")
@_out
def extract(campaign: Path, batch: int, batches: int, out: Path) -> None:
    """Extract the observables of a batch of runs."""
    opened = open_campaign(campaign)
    write_csv(out, pd.DataFrame(extract_campaign(batch_of(opened, batch, batches), opened.bench)))


@click.command("join")
@_campaign
@click.argument("batch_files", nargs=-1, required=True, type=_FILE)
@click.option("--runs", type=_FILE, required=True, help="runs.csv to write.")
@click.option("--observables", type=_FILE, required=True, help="observables.json to write.")
@click.option("--quality", type=_FILE, required=True, help="quality.json to write.")
@click.option(
    "--preload-edge", "edges", type=float, multiple=True, help="Edge of a preload bin [N]; repeatable."
)
def join(
    campaign: Path,
    batch_files: tuple[Path, ...],
    runs: Path,
    observables: Path,
    quality: Path,
    edges: tuple[float, ...],
) -> None:
    """Join batches to runs.csv, observables.json and quality.json."""
    bench = open_campaign(campaign).bench
    batches = [pd.read_csv(path) for path in batch_files]
    table, counts = join_batches(batches, bench, edges or PRELOAD_EDGES)
    write_csv(runs, table)
    write_json(observables, observable_infos())
    write_json(quality, counts)


@click.command("gap")
@_campaign
@click.option(
    "--kappa", type=float, default=53.196, show_default=True, help="Permittivity at the meter's frequency."
)
@_out
def gap(campaign: Path, kappa: float, out: Path) -> None:
    """Capacitance readings as mean gaps (gap.csv)."""
    opened = open_campaign(campaign)
    write_csv(out, pd.DataFrame(gap_table(read_capacitance(opened), kappa, opened.bench)))


@click.command("bursts")
@_campaign
@_out
def bursts(campaign: Path, out: Path) -> None:
    """Free swings of the bare load cell (bursts.csv)."""
    found = read_bursts(open_campaign(campaign))
    columns = {"frequency_hz": found.frequency, "frequency_hz_sd": found.frequency_sd}
    columns |= {"damping_ratio": found.damping_ratio, "damping_ratio_sd": found.damping_ratio_sd}
    write_csv(out, pd.DataFrame(columns))


@click.command("spectra")
@_campaign
@_out
def spectra(campaign: Path, out: Path) -> None:
    """Permittivity spectra, joined (spectra.csv)."""
    rows = [
        {"source": spectrum.source, "frequency_hz": f, "relative_permittivity": k}
        for spectrum in read_spectra(open_campaign(campaign))
        for f, k in zip(spectrum.frequency, spectrum.permittivity, strict=True)
    ]
    write_csv(out, pd.DataFrame(rows, columns=["source", "frequency_hz", "relative_permittivity"]))


COMMANDS = [check, extract, join, gap, bursts, spectra]
