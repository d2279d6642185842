"""Commit to answers before anything is diagnosed, and to verdicts before an answer is opened.

A commitment is SHA-256 over a secret salt and the answer's canonical JSON: it binds, and tells nothing. The
plan's seed is drawn from the system's entropy unless one is given, and lies with the answers.
"""

from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from eaclutch.blind.case import build_case
from eaclutch.blind.generate import answer_of, tables_of, write_tables
from eaclutch.blind.plan import Entry, make_plan
from eaclutch.blind.rawlogs import write_campaign
from eaclutch.blind.sizes import Size, size_of
from eaclutch.files import plain, read_json, sha256, write_json
from eaclutch.records import InputError


def draw_plan(size_name: str, seed: int | None, limits: Mapping[str, float] | None) -> dict[str, Any]:
    """The secret plan of a size, to be kept with the answers. ``seed`` None: drawn from the system."""
    secret = secrets.randbits(62) if seed is None else seed
    size = size_of(size_name)
    entries = make_plan(
        "sealed",
        secret,
        none=size.none,
        unknown=size.unknown,
        singles=size.singles,
        pairs=size.pairs,
        limits=dict(limits) if limits else None,
        prefix=size_name.replace("_", "-"),
    )
    raw = _raw_cases(entries, size)
    salts = [secrets.token_hex(32) if seed is None else _derived(secret, e.case) for e in entries]
    return {
        "schema": 1,
        "size": size_name,
        "open_seed": seed is not None,
        "limits": dict(limits or {}),
        "entries": [
            asdict(entry) | {"raw": entry.case in raw, "salt": salt}
            for entry, salt in zip(entries, salts, strict=True)
        ],
    }


def _derived(seed: int, case: str) -> str:
    """Salt of an open, reproducible set: nobody is kept from the answers there, the binding stays."""
    return hashlib.sha256(f"{seed}/{case}".encode()).hexdigest()


def _raw_cases(entries: tuple[Entry, ...], size: Size) -> set[str]:
    """Which cases are written as logs: spread over the kinds, so that the two levels can be compared."""
    kinds = ("none", "single", "unknown", "pair")
    queues = {kind: [e.case for e in entries if e.kind == kind] for kind in kinds}
    chosen: list[str] = []
    while len(chosen) < size.raw:
        for kind in kinds:
            if queues[kind] and len(chosen) < size.raw:
                chosen.append(queues[kind].pop())
    return set(chosen)


def commitment(answer: Mapping[str, Any], salt: str) -> str:
    """SHA-256 of salt and canonical JSON of the answer, in hexadecimal."""
    text = json.dumps(plain(answer), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(f"{salt}\n{text}".encode()).hexdigest()


def seal_batch(plan: Mapping[str, Any], batch: int, cases: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Write the batch's campaigns below ``cases``; returns (public commitments, secret answers).

    A case whose campaign is raw is a whole campaign folder, the others hold runs.csv and bursts.csv instead of
    logs.
    """
    size = size_of(plan["size"])
    rows = plan["entries"][batch * size.batch : (batch + 1) * size.batch]
    public: dict[str, Any] = {"schema": 1, "size": plan["size"], "batch": batch, "cases": {}}
    hidden: dict[str, Any] = {"schema": 1, "size": plan["size"], "batch": batch, "answers": {}}
    for row in rows:
        entry = entry_of(row)
        case = build_case(entry)
        answer = plain(answer_of(case, truth=True) | {"level": "logs" if row["raw"] else "tables"})
        if row["raw"]:
            write_campaign(case, cases / entry.case)
        else:
            write_tables(tables_of(case), cases / entry.case)
        public["cases"][entry.case] = {
            "commitment": commitment(answer, row["salt"]),
            "level": answer["level"],
        }
        hidden["answers"][entry.case] = {"salt": row["salt"], "answer": answer}
    return public, hidden


def entry_of(row: Mapping[str, Any]) -> Entry:
    """A plan's row as an entry."""
    effects = tuple((str(name), float(size)) for name, size in row["effects"])
    fields = {key: row[key] for key in ("case", "namespace", "seed", "kind", "misfit", "misfit_law")}
    return Entry(effects=effects, **fields)


SIDES = ("parameters", "without", "run")  # optional files beside a verdict


def freeze(verdicts: Path, cases: list[str]) -> dict[str, Any]:
    """Hashes of all verdict files of one method, by case; a missing verdict is frozen as missing."""
    names = [f"{case}{end}.json" for case in cases for end in ("", *(f".{side}" for side in SIDES))]
    hashes = {name: sha256(verdicts / name) for name in names if (verdicts / name).is_file()}
    whole = hashlib.sha256(json.dumps(hashes, sort_keys=True).encode()).hexdigest()
    return {"schema": 1, "method": verdicts.name, "cases": cases, "files": hashes, "whole": whole}


def open_answers(commitments: list[Path], answers: list[Path]) -> dict[str, dict[str, Any]]:
    """Answers by case, each checked against its commitment. Raises InputError where one was changed."""
    promised: dict[str, dict[str, Any]] = {}
    for path in commitments:
        promised |= read_json(path)["cases"]
    opened: dict[str, dict[str, Any]] = {}
    for path in answers:
        for case, content in read_json(path)["answers"].items():
            if case not in promised:
                raise InputError(path, f"{case} was never committed to", "seal the benchmark again")
            if commitment(content["answer"], content["salt"]) != promised[case]["commitment"]:
                raise InputError(
                    path, f"the answer to {case} is not the sealed one", "seal the benchmark again"
                )
            opened[case] = content["answer"]
    if missing := sorted(set(promised) - set(opened)):
        raise InputError(answers[0].parent, f"no answer to {missing[0]}", "give all answer files")
    return opened


def check_frozen(frozen: Mapping[str, Any], verdicts: Path) -> dict[str, dict[str, Any]]:
    """Verdicts by case as frozen. Raises InputError where a file changed after it was hashed."""
    for name, digest in frozen["files"].items():
        path = verdicts / Path(name).name
        if not path.is_file() or sha256(path) != digest:
            raise InputError(path, "changed after the verdicts were frozen", "diagnose and freeze again")
    return {
        case: read_json(verdicts / f"{case}.json")
        for case in frozen["cases"]
        if f"{case}.json" in frozen["files"]
    }


def record_opening(path: Path, frozen: list[dict[str, Any]]) -> dict[str, str]:
    """What was frozen when the answers were first opened, {method: hash}; written the first time.

    Raises InputError where a method of that time comes with other verdicts now.
    """
    hashes = {item["method"]: item["whole"] for item in frozen}
    if not path.is_file():
        write_secret(path, {"schema": 1, "methods": hashes})
    first = dict(read_json(path)["methods"])
    for method, whole in hashes.items():
        if first.get(method, whole) != whole:
            what = f"the answers were opened when {method} had other verdicts"
            raise InputError(path, what, "seal a new benchmark for new verdicts")
    return first


def read_sides(verdicts: Path, cases: list[str]) -> dict[str, dict[str, Any]]:
    """What lies beside the verdicts, by case: calibrated parameters and seconds, where given."""
    found: dict[str, dict[str, Any]] = {}
    for case in cases:
        paths = {side: verdicts / f"{case}.{side}.json" for side in SIDES}
        found[case] = {side: read_json(path) for side, path in paths.items() if path.is_file()}
    return found


def write_secret(path: Path, content: Mapping[str, Any]) -> None:
    """Write a file of answers, readable by its owner alone, in a folder that is so too if it is made here."""
    path.parent.parent.mkdir(parents=True, exist_ok=True)
    path.parent.mkdir(mode=0o700, exist_ok=True)
    write_json(path, content)
    path.chmod(0o600)
