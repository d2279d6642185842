"""``eaclutch blind``: campaigns whose effect is withheld, and the score of a diagnosis on them."""

from __future__ import annotations

from pathlib import Path

import click

from eaclutch.blind.generate import generate_case, write_tables
from eaclutch.blind.plan import make_plan
from eaclutch.files import write_json


@click.group("blind")
def blind() -> None:
    """The sealed benchmark."""


@blind.command("dev")
@click.option("--seed", type=click.IntRange(min=0), required=True)
@click.option("--none", "none", type=click.IntRange(min=0), default=20, show_default=True)
@click.option("--unknown", type=click.IntRange(min=0), default=13, show_default=True)
@click.option("--each-single", type=click.IntRange(min=0), default=2, show_default=True)
@click.option("--pairs", type=click.IntRange(min=0), default=5, show_default=True)
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True)
def dev(seed: int, none: int, unknown: int, each_single: int, pairs: int, out: Path) -> None:
    """Write an open development set: <out>/cases/<case>/ and <out>/answers/<case>.json.

    Its seeds are a namespace of their own: no sealed case is ever among them.
    """
    plan = make_plan("dev", seed, none=none, unknown=unknown, each_single=each_single, pairs=pairs)
    for entry in plan:
        tables, answer = generate_case(entry)
        write_tables(tables, out / "cases" / entry.case)
        write_json(out / "answers" / f"{entry.case}.json", answer)


COMMANDS: list[click.Command] = [blind]
