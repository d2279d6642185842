"""The report, the manifest and its check, and the config's README."""

from __future__ import annotations

from pathlib import Path

import click

from eaclutch.config.slices import parse_settings
from eaclutch.files import write_text
from eaclutch.records import InputError

_FOLDER = click.Path(file_okay=False, path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.option("--results", type=_FOLDER, required=True, help="The campaign's results folder.")
@click.option("--settings", default="{}", help="The config as JSON, for the page's provenance.")
@click.option("--output", type=_FILE, required=True, help="Where the page goes.")
def report(results: Path, settings: str, output: Path) -> None:
    """One self-contained page on what was measured, fitted, predicted and found missing."""
    from eaclutch.reporting.page import render
    from eaclutch.reporting.results import read_results

    write_text(output, render(read_results(results), parse_settings(settings)))


@click.command()
@click.argument("first", type=_FOLDER)
@click.argument("second", type=_FOLDER)
@click.option("--output", type=_FILE, required=True, help="Where the page goes.")
def compare(first: Path, second: Path, output: Path) -> None:
    """Two results folders on one page: before and after a change of rig, film or model."""
    from eaclutch.reporting.compare import render_comparison
    from eaclutch.reporting.results import read_results

    write_text(output, render_comparison(read_results(first), read_results(second)))


@click.command()
@click.option("--results", type=_FOLDER, required=True, help="The campaign's results folder.")
@click.option("--settings", default="{}", help="The config as JSON.")
@click.option("--output", type=_FILE, required=True, help="Where the manifest goes.")
def manifest(results: Path, settings: str, output: Path) -> None:
    """Checksums of inputs and results, with config, seed, versions and commit."""
    from eaclutch.manifest import write_manifest

    write_manifest(results, parse_settings(settings), output)


@click.command()
@click.argument("results", type=_FOLDER)
@click.option("--campaign", type=_FOLDER, default=None, help="Where the campaign lies now, if it was moved.")
def verify(results: Path, campaign: Path | None) -> None:
    """Check results and inputs against the manifest; every difference is listed."""
    from eaclutch.manifest import verify as differences

    found = differences(results, campaign)
    for line in found:
        click.echo(line)
    if found:
        raise InputError(results, f"{len(found)} differences from its manifest", "run the campaign again")
    click.echo(f"{results}: all results and inputs stand as in the manifest")


@click.command("config-readme")
@click.option("--output", type=_FILE, default=Path("config/README.md"), show_default=True)
def config_readme(output: Path) -> None:
    """Write the table of all config keys from the schema."""
    from eaclutch.config.readme import config_readme as text

    write_text(output, text())


COMMANDS: list[click.Command] = [report, compare, manifest, verify, config_readme]
