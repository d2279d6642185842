"""``eaclutch blind``: campaigns whose effect is withheld, and the score of a diagnosis on them."""

from __future__ import annotations

import hashlib
import logging
from datetime import date
from pathlib import Path

import click

from eaclutch.blind import sealing
from eaclutch.blind.comparators import Fits, compare
from eaclutch.blind.generate import generate_case, write_tables
from eaclutch.blind.measured_noise import measure_noise
from eaclutch.blind.plan import make_plan
from eaclutch.blind.scoring import score
from eaclutch.config.slices import parse_settings
from eaclutch.files import read_json, write_json, write_text
from eaclutch.provenance import commit
from eaclutch.rig.log_names import EXTENSIONS

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
@click.option(
    "--limits",
    type=_FILE,
    help="JSON {effect: size}: detection limits; sizes are 2-4 times them.",
)
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
@click.option(
    "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of simulated campaigns."
)
@click.option(
    "--code", default="", help="Hash of the diagnosing code: verdicts of another one are made anew."
)
@click.option("--verdicts", type=_FOLDER, required=True, help="Folder for <case>.json (as diagnosis.json).")
@click.option("--fits", type=_FOLDER, help="Folder for each case's fits, from which comparators work.")
@_output
def diagnose(
    commitments: Path,
    cases: Path,
    method: str,
    settings: str,
    seed: int,
    code: str,
    verdicts: Path,
    fits: Path | None,
    output: Path,
) -> None:
    """Diagnose a batch of sealed campaigns; verdicts that the same code left there are kept."""
    from eaclutch.cli.blind_methods import diagnose_case  # the other commands need no solver

    seconds = {}
    mark = hashlib.sha256(f"{code}\n{settings}\n{seed}\n{method}".encode()).hexdigest()
    for case in sorted(read_json(commitments)["cases"]):
        target, run = verdicts / f"{case}.json", verdicts / f"{case}.run.json"
        if not (target.is_file() and run.is_file() and read_json(run).get("mark") == mark):
            document, sides, fitted, elapsed = diagnose_case(
                cases / case, method, parse_settings(settings), seed
            )
            if fits is not None:
                write_json(fits / f"{case}.json", fitted)
            for side, content in sides.items():
                write_json(verdicts / f"{case}.{side}.json", content)
            write_json(target, document)
            write_json(run, {"seconds": elapsed, "mark": mark})
            logging.info("%s: %s", case, document["verdict"]["effects"])
        seconds[case] = read_json(run)["seconds"]
    write_json(output, {"schema": 1, "method": method, "seconds": seconds})


@blind.command("compare")
@click.option("--fits", type=_FOLDER, required=True, help="Folder of the cases' fits.")
@click.option("--method", required=True, help="aic, bic, largest_residual, loo or nameless_gp.")
@click.option("--verdicts", type=_FOLDER, required=True, help="Folder for <case>.json.")
@click.argument("commitments", nargs=-1, required=True, type=_FILE)
@_output
def compare_with(
    fits: Path, method: str, verdicts: Path, commitments: tuple[Path, ...], output: Path
) -> None:
    """What a simpler method says on all cases, from the same fits."""
    cases = sorted(case for path in commitments for case in read_json(path)["cases"])
    for case in cases:
        write_json(
            verdicts / f"{case}.json", compare(method, Fits.read(read_json(fits / f"{case}.json")), case)
        )
    write_json(output, {"schema": 1, "method": method, "cases": cases})


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
@click.option(
    "--opened", type=_FILE, required=True, help="Record of what was frozen when answers were opened."
)
@click.option("--forecast", type=_FILE, help="confusion.json: the forecast beside which the outcome is put.")
@_output
def unseal(
    commitments: tuple[Path, ...],
    answers: tuple[Path, ...],
    frozen: tuple[Path, ...],
    verdicts: Path,
    opened: Path,
    forecast: Path | None,
    output: Path,
) -> None:
    """Check verdicts and answers against their hashes and score them.

    The first opening records the hashes: a method that was frozen by then cannot be scored with other verdicts
    later, and one that comes later is marked so.
    """
    hashes = [read_json(path) for path in frozen]
    found = {item["method"]: sealing.check_frozen(item, verdicts / item["method"]) for item in hashes}
    first = sealing.record_opening(opened, hashes)
    answered = sealing.open_answers(list(commitments), list(answers))
    sides = {method: sealing.read_sides(verdicts / method, list(answered)) for method in found}
    document = score(answered, found, sides, read_json(forecast) if forecast else None)
    for item in hashes:
        document["methods"][item["method"]] |= {
            "frozen": item["whole"],
            "after_opening": item["method"] not in first,
        }
    write_json(output, document)


@blind.command("report")
@click.option("--score", "score_file", type=_FILE, required=True, help="score.json of one size.")
@click.option("--newest", type=_FILE, help="A second place for the page.")
@_output
def report(score_file: Path, newest: Path | None, output: Path) -> None:
    """The benchmark's page, all of it from the score."""
    from eaclutch.reporting.blind_page import blind_page  # the other commands draw nothing

    page = blind_page(read_json(score_file))
    for path in (output, newest):
        if path is not None:
            write_text(path, page)


@blind.command("noise")
@click.option("--campaign", type=_FOLDER, required=True, help="Folder of published recordings.")
@_output
def noise(campaign: Path, output: Path) -> None:
    """Measure what disturbs published logs: the statistics that the generator's noise follows."""
    logs = [path for path in (campaign / "tensile").iterdir() if path.name.endswith(EXTENSIONS)]
    found = {"command": "eaclutch blind noise --campaign <published recordings> --output <file>"}
    write_json(
        output, found | {"commit": commit(), "date": f"{date.today()}", "sessions": measure_noise(logs)}
    )


COMMANDS: list[click.Command] = [blind]
