"""Simulated campaigns of the open namespace of ``eaclutch.blind``, never a sealed case: asked for, made, read."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from multiprocessing import Pool
from pathlib import Path
from typing import Any

from eaclutch.blind import plan
from eaclutch.blind.generate import generate_case, write_tables
from eaclutch.cli.blind_methods import read_case
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.files import read_json

LIMITS = Path(__file__).parents[1] / "config" / "blind_limits.json"
Job = tuple[plan.Entry, Path]  # a case, and the folder that keeps what is done of it


def parser_of(description: str) -> argparse.ArgumentParser:
    """The command line that all scripts on such campaigns share."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--record", action="store_true")
    return parser


def asked_singles(description: str) -> tuple[argparse.Namespace, Sequence[plan.Entry]]:
    """The command line of a script on campaigns with one effect each, and those campaigns."""
    parser = parser_of(description)
    parser.add_argument("--each", type=int, default=1, help="campaigns an effect")
    chosen = parser.parse_args()
    entries = plan.make_plan(
        "dev", chosen.seed, none=0, unknown=0, each_single=chosen.each, pairs=0, limits=read_json(LIMITS)
    )
    return chosen, entries


def made(job: Job) -> tuple[dict[str, Any], Study]:
    """The answer of a case, and its campaign under diagnosis."""
    entry, work = job
    tables, answer = generate_case(entry)
    folder = work / "cases" / entry.case
    write_tables(tables, folder)
    return answer, Study(read_case(folder, "library", {}), load_thresholds())


def for_each(do: Callable[[Job], None], entries: Sequence[plan.Entry], work: Path, jobs: int) -> None:
    """``do`` every case in processes of their own, and say how far it is."""
    with Pool(jobs) as pool:
        for done, _ in enumerate(pool.imap_unordered(do, [(entry, work) for entry in entries]), 1):
            print(f"{done} of {len(entries)}", flush=True)
