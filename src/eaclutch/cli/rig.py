"""Commands of the rig room: from a campaign's folder to tables of observables."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
import pandas as pd

from eaclutch.files import atomic, read_json, write_csv, write_json
from eaclutch.manifest import captured, remember_campaign, runs_of_batch
from eaclutch.records import Bench
from eaclutch.rig.batch import extract_campaign, join_batches
from eaclutch.rig.campaign import list_campaign, open_campaign
from eaclutch.rig.capacitance import left_out, read_capacitance
from eaclutch.rig.gap import gap_table
from eaclutch.rig.load_cell import read_bursts
from eaclutch.rig.logs import read_log
from eaclutch.rig.spectra import read_spectra
from eaclutch.rig.table import PRELOAD_EDGES, observable_infos
from eaclutch.rig.traces import trace

_FOLDER = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)
_campaign = click.argument("campaign", type=_FOLDER)
_exclude = click.option(
    "--exclude", default="{}", help="Runs to leave out besides those of campaign.yaml, JSON: {run: reason}."
)
_out = click.option("--out", type=_FILE, required=True, help="File to write.")


def excluding(bench: Bench, further: str) -> Bench:
    """The bench with the config's exclusions (JSON) besides its own."""
    return replace(bench, exclude={**bench.exclude, **json.loads(further)})


@click.command("check")
@_campaign
@click.option("--batch-size", type=int, default=24, show_default=True, help="Runs that one job extracts.")
@_out
def check(campaign: Path, batch_size: int, out: Path) -> None:
    """List a campaign with checksums and batches (capture.json)."""
    opened = open_campaign(campaign)
    listing = list_campaign(opened) | {"capacitance_left_out": left_out(opened)}
    write_json(out, captured(opened, listing, batch_size))
    remember_campaign(campaign, out.parent)


@click.command("extract")
@_campaign
@click.option("--capture", type=_FILE, help="capture.json, which says what runs a batch holds.")
@click.option(
    "--batch", type=int, default=0, show_default=True, help="Which batch of runs; all without --capture."
)
@click.option("--traces", type=_FILE, help="Thumbnails of the batch's runs to write (npz).")
@_exclude
@_out
def extract(
    campaign: Path, capture: Path | None, batch: int, traces: Path | None, exclude: str, out: Path
) -> None:
    """Extract the observables of a batch of runs."""
    opened = open_campaign(campaign)
    bench = excluding(opened.bench, exclude)
    chosen = (
        runs_of_batch(read_json(capture), batch) if capture else {log.settings.run for log in opened.logs}
    )
    logs = [log for log in opened.logs if log.settings.run in chosen]
    write_csv(out, pd.DataFrame(extract_campaign(logs, bench)))
    if traces:
        found = {
            log.settings.run: trace(read_log(log.path))
            for log in logs
            if log.settings.run not in bench.exclude
        }
        with atomic(traces) as temporary:
            np.savez(temporary, allow_pickle=False, **found)


@click.command("join")
@_campaign
@click.argument("batch_files", nargs=-1, required=True, type=_FILE)
@click.option("--runs", type=_FILE, required=True, help="runs.csv to write.")
@click.option("--observables", type=_FILE, required=True, help="observables.json to write.")
@click.option("--quality", type=_FILE, required=True, help="quality.json to write.")
@click.option(
    "--preload-edges", default=json.dumps(PRELOAD_EDGES), help="Edges of the preload bins [N], JSON."
)
@_exclude
def join(
    campaign: Path,
    batch_files: tuple[Path, ...],
    runs: Path,
    observables: Path,
    quality: Path,
    preload_edges: str,
    exclude: str,
) -> None:
    """Join batches to runs.csv, observables.json and quality.json."""
    bench = excluding(open_campaign(campaign).bench, exclude)
    batches = [pd.read_csv(path) for path in batch_files]
    table, counts = join_batches(batches, bench, json.loads(preload_edges))
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
