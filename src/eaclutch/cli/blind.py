"""``eaclutch blind``: campaigns whose effect is withheld, and the score of a diagnosis on them."""

from __future__ import annotations

import json
from pathlib import Path

import click

from eaclutch.blind import sealing
from eaclutch.blind.generate import generate_case, write_tables
from eaclutch.blind.plan import make_plan
from eaclutch.blind.scoring import score
from eaclutch.files import read_json, write_json
from eaclutch.records import InputError

_FILE = click.Path(dir_okay=False, path_type=Path)
_FOLDER = click.Path(file_okay=False, path_type=Path)
_output = click.option("--output", type=_FILE, required=True, help="File to write.")


@click.group("blind")
def blind() -> None:
    """The sealed benchmark: plan, seal, diagnose, freeze, unseal."""


@blind.command("dev")
@click.option("--seed", type=click.IntRange(min=0), required=True, help="Seed of the development set.")
@click.option("--none", "none", type=click.IntRange(min=0), default=20, show_default=True)
@click.option("--unknown", type=click.IntRange(min=0), default=13, show_default=True)
@click.option("--each-single", type=click.IntRange(min=0), default=2, show_default=True)
@click.option("--pairs", type=click.IntRange(min=0), default=5, show_default=True)
@click.option("--out", type=_FOLDER, required=True, help="Folder to fill.")
def dev(seed: int, none: int, unknown: int, each_single: int, pairs: int, out: Path) -> None:
    """Write an open development set: <out>/cases/<case>/ and <out>/answers/<case>.json.

    Its seeds are a namespace of their own: no sealed case is ever among them.
    """
    plan = make_plan("dev", seed, none=none, unknown=unknown, each_single=each_single, pairs=pairs)
    for entry in plan:
        tables, answer = generate_case(entry)
        write_tables(tables, out / "cases" / entry.case)
        write_json(out / "answers" / f"{entry.case}.json", answer)


@blind.command("plan")
@click.option("--size", required=True, help="blind_small, blind or blind_long.")
@click.option(
    "--seed", type=click.IntRange(min=0), help="Open, reproducible set; default: drawn and kept secret."
)
@click.option("--limits", type=_FILE, help="JSON {effect: size}: the frozen forecast's detection limits.")
@_output
def plan(size: str, seed: int | None, limits: Path | None, output: Path) -> None:
    """Draw the secret plan of a benchmark; it belongs with the answers."""
    sealing.write_secret(output, sealing.draw_plan(size, seed, read_json(limits) if limits else None))


@blind.command("seal")
@click.option("--plan", "plan_file", type=_FILE, required=True, help="The secret plan.")
@click.option("--batch", type=click.IntRange(min=0), required=True, help="Which batch of its cases.")
@click.option("--cases", type=_FOLDER, required=True, help="Folder of the campaigns to write.")
@click.option("--commitments", type=_FILE, required=True, help="Public hashes of the answers to write.")
@click.option("--answers", type=_FILE, required=True, help="Secret answers to write.")
def seal(plan_file: Path, batch: int, cases: Path, commitments: Path, answers: Path) -> None:
    """Write a batch of campaigns, commit to their answers, and put the answers apart."""
    public, hidden = sealing.seal_batch(read_json(plan_file), batch, cases)
    sealing.write_secret(answers, hidden)
    write_json(commitments, public)


@blind.command("diagnose")
@click.option("--commitments", type=_FILE, required=True, help="Names the batch's cases.")
@click.option("--cases", type=_FOLDER, required=True, help="Folder of the campaigns.")
@click.option(
    "--method", default="library", show_default=True, help="library, without-<effect>, or a comparator."
)
@click.option("--settings", default="{}", help="Config sections model, priors and diagnosis as JSON.")
@click.option("--seed", type=int, default=1, show_default=True, help="Seed of simulated campaigns.")
@click.option(
    "--verdicts", type=_FOLDER, required=True, help="Folder for <case>.json (contract: diagnosis.json)."
)
@_output
def diagnose(
    commitments: Path, cases: Path, method: str, settings: str, seed: int, verdicts: Path, output: Path
) -> None:
    """Diagnose a batch of sealed campaigns; verdicts that are there already are kept."""
    from eaclutch.cli.blind_methods import diagnose_case  # the other commands need no solver

    seconds = {}
    for case in sorted(read_json(commitments)["cases"]):
        target = verdicts / f"{case}.json"
        stamp = verdicts / f"{case}.seconds.json"
        if not (target.is_file() and stamp.is_file()):
            document, parameters, elapsed = diagnose_case(cases / case, method, json.loads(settings), seed)
            write_json(verdicts / f"{case}.parameters.json", parameters)
            write_json(target, document)
            write_json(stamp, elapsed)
        seconds[case] = read_json(stamp)
    write_json(output, {"schema": 1, "method": method, "seconds": seconds})


@blind.command("freeze")
@click.option("--verdicts", type=_FOLDER, required=True, help="Folder of one method's verdicts.")
@click.argument("commitments", nargs=-1, required=True, type=_FILE)
@_output
def freeze(verdicts: Path, commitments: tuple[Path, ...], output: Path) -> None:
    """Hash one method's verdicts (a rival's, too), before any answer is opened."""
    cases = sorted(case for path in commitments for case in read_json(path)["cases"])
    write_json(output, sealing.freeze(verdicts, cases))


@blind.command("unseal")
@click.option("--commitments", type=_FILE, multiple=True, required=True, help="All batches' public hashes.")
@click.option("--answers", type=_FILE, multiple=True, required=True, help="All batches' secret answers.")
@click.option("--frozen", type=_FILE, multiple=True, required=True, help="Frozen hashes, one a method.")
@click.option("--verdicts", type=_FOLDER, required=True, help="Folder with a folder of verdicts a method.")
@click.option("--forecast", type=_FILE, help="confusion.json: the forecast beside which the outcome is put.")
@_output
def unseal(
    commitments: tuple[Path, ...],
    answers: tuple[Path, ...],
    frozen: tuple[Path, ...],
    verdicts: Path,
    forecast: Path | None,
    output: Path,
) -> None:
    """Check verdicts and answers against their hashes and score them, once."""
    if output.exists():
        raise InputError(output, "the benchmark is unsealed already", "seal a new one, or remove the score")
    hashes = [read_json(path) for path in frozen]
    found = {item["method"]: sealing.check_frozen(item, verdicts / item["method"]) for item in hashes}
    opened = sealing.open_answers(list(commitments), list(answers))
    levels = {case: row["level"] for path in commitments for case, row in read_json(path)["cases"].items()}
    sides = {method: sealing.read_sides(verdicts / method, list(opened)) for method in found}
    document = score(opened, found, sides, levels, read_json(forecast) if forecast else None)
    document["frozen"] = {item["method"]: item["whole"] for item in hashes}
    write_json(output, document)


COMMANDS: list[click.Command] = [blind]
