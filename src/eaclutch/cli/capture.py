"""From a folder, the live rig or the simulated rig to a checked list of recordings."""

from __future__ import annotations

import json
from pathlib import Path

import click

from eaclutch.manifest import write_capture
from eaclutch.records import InputError
from eaclutch.rig.campaign import open_campaign


@click.command()
@click.option(
    "--campaign",
    type=click.Path(file_okay=False, path_type=Path),
    required=True,
    help="The campaign's folder.",
)
@click.option(
    "--settings", default="{}", help="JSON with the config's capture part and observables.batch_size."
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the simulated rig.")
@click.option(
    "--output", type=click.Path(dir_okay=False, path_type=Path), required=True, help="capture.json."
)
def capture(campaign: Path, settings: str, seed: int, output: Path) -> None:
    """Add runs from the source that the settings name, then list and check the campaign."""
    chosen = json.loads(settings)
    source = chosen.get("capture", {}).get("source", "recordings")
    if source != "recordings":
        raise InputError(
            "capture.source", f"{source} is not connected yet", "capture the runs first, then use recordings"
        )
    write_capture(open_campaign(campaign), chosen.get("observables.batch_size", 24), output)


COMMANDS = [capture]
