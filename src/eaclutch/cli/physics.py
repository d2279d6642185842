"""Commands of the physics room."""

from __future__ import annotations

import click


@click.command("effects")
@click.option(
    "--format",
    "shown",
    type=click.Choice(["list", "markdown", "json"]),
    default="list",
    show_default=True,
    help="A line an effect, the page docs/effects.md, or all figures as JSON.",
)
def effects(shown: str) -> None:
    """List the physical effects that the library knows."""
    import json

    from eaclutch.physics import effect_table

    texts = {
        "list": effect_table.as_lines,
        "markdown": lambda: effect_table.as_markdown().rstrip("\n"),
        "json": lambda: json.dumps(effect_table.as_data(), indent=1),
    }
    click.echo(texts[shown]())


COMMANDS: list[click.Command] = [effects]
