"""Commands of the simulation room: campaigns as the rig would have recorded them."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import click


@click.command("simulate")
@click.option(
    "--recipe",
    type=click.Path(dir_okay=False, path_type=Path),
    required=True,
    help="What to simulate (yaml, schema recipe).",
)
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    required=True,
    help="Folder of the campaign to make.",
)
@click.option("--seed", type=click.IntRange(min=0), default=None, help="Instead of the recipe's seed.")
@click.option("--replace", is_flag=True, help="Put the new campaign in the place of one that is there.")
def simulate(recipe: Path, output: Path, seed: int | None, replace: bool) -> None:
    """Write a simulated campaign in the layout of a recorded one."""
    import numpy as np

    from eaclutch.config.bench import bench_from_facts
    from eaclutch.config.document import check, load_schema, read_yaml, with_defaults
    from eaclutch.records import InputError
    from eaclutch.simulation.campaign import simulate_campaign
    from eaclutch.simulation.recipe import from_facts

    document = read_yaml(recipe)
    check(document, "recipe", recipe)
    facts = with_defaults(document, load_schema("recipe"))
    campaign = {"name": facts["name"], **facts["campaign"]}
    check(campaign, "campaign", f"{recipe}, campaign")
    bench = bench_from_facts(with_defaults(campaign, load_schema("campaign")), recipe)
    if output.exists() and any(output.iterdir()) and not replace:
        raise InputError(output, "is not empty", "name another folder, or add --replace")
    rng = np.random.default_rng(facts["seed"] if seed is None else seed)
    made = from_facts(facts, rng)
    output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{output.name}.", dir=output.parent) as temporary:
        new = Path(temporary) / "campaign"
        done = simulate_campaign(new, made.plan, bench, made.effects, made.parameters, made.noise, rng)
        if output.exists():
            shutil.rmtree(output)
        new.rename(output)
    click.echo(f"{len(done.conditions)} runs in {output}")


@click.command("bench-noise")
@click.option("--campaign", type=click.Path(path_type=Path), required=True, help="Folder of recordings.")
@click.option(
    "--output", type=click.Path(dir_okay=False, path_type=Path), required=True, help="JSON file to write."
)
@click.option(
    "--every", type=click.IntRange(min=1), default=7, show_default=True, help="Spectra of one log in so many."
)
def bench_noise(campaign: Path, output: Path, every: int) -> None:
    """Measure the noise of a bench from its recordings, for the simulated rig."""
    from datetime import date

    from eaclutch.files import write_json
    from eaclutch.provenance import commit
    from eaclutch.rig.campaign import open_campaign
    from eaclutch.simulation.measured_noise import measure

    opened = open_campaign(campaign)
    command = f"eaclutch bench-noise --campaign <recordings> --every {every} --output <file>"
    found = measure(opened.logs, opened.bench, every)
    write_json(output, {"command": command, "date": date.today().isoformat(), "commit": commit(), **found})


COMMANDS: list[click.Command] = [simulate, bench_noise]
