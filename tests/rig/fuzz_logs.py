"""Mutated logs by the thousand: right numbers, numbers with a flag, or one clear error; nothing else.

    python tests/rig/fuzz_logs.py --count 10000 --output docs/measurements/log_fuzz.json

A log is *silently wrong* if it is read without a new flag and an observable is 6 standard uncertainties off, or is
there where it was not; a *traceback* is any exception that is not an InputError.
"""

from __future__ import annotations

import argparse
import gzip
import json
import lzma
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from eaclutch.records import Bench, InputError
from eaclutch.rig.extract import extract
from eaclutch.rig.logs import read_log, write_log
from eaclutch.rig.observables import OBSERVABLES
from rig.made_run import Made, make_run

Rng = np.random.Generator
BENCH = Bench("fuzz")
SHORT = Made(before=1.4, travel=1e-4, after=0.35, capacity=0.4, hold=0.38)
TINY = Made(before=0.1, travel=5e-5, after=0.05)  # for the readers: too short for most observables
TINY_SHARE = 0.88
LIMIT = 6.0  # standard uncertainties


def lines_of(raw: bytes) -> list[bytes]:
    return raw.split(b"\n")


def flip(raw: bytes, rng: Rng) -> bytes:
    out = bytearray(raw)
    for at in rng.integers(0, len(out), rng.integers(1, 40)):
        out[at] = rng.integers(0, 256)
    return bytes(out)


def delete(raw: bytes, rng: Rng) -> bytes:
    at, size = rng.integers(0, len(raw)), int(rng.choice([1, 3, 12, 64, 4096]))
    return raw[:at] + raw[at + size :]


def insert(raw: bytes, rng: Rng) -> bytes:
    junk = [
        b"\x00",
        b"\n\n",
        "ü€\u2028".encode(),
        b"nan",
        b"-",
        b",",
        b"\xff\xfe",
        b"1e400",
        b'"',
        rng.bytes(200),
    ]
    at = rng.integers(0, len(raw))
    return raw[:at] + junk[rng.integers(len(junk))] + raw[at:]


def cut(raw: bytes, rng: Rng) -> bytes:
    return raw[: rng.integers(0, len(raw))]


def drop_lines(raw: bytes, rng: Rng) -> bytes:
    lines = lines_of(raw)
    at, size = rng.integers(0, len(lines)), int(rng.choice([1, 5, 300]))
    return b"\n".join(lines[:at] + lines[at + size :])


def repeat_lines(raw: bytes, rng: Rng) -> bytes:
    lines = lines_of(raw)
    at, size = rng.integers(0, len(lines)), int(rng.choice([1, 5, 300]))
    return b"\n".join(lines[: at + size] + lines[at:])


def merge_lines(raw: bytes, rng: Rng) -> bytes:
    lines = lines_of(raw)
    at = rng.integers(0, len(lines) - 1)
    return b"\n".join([*lines[:at], lines[at] + lines[at + 1], *lines[at + 2 :]])


def shuffle_lines(raw: bytes, rng: Rng) -> bytes:
    lines = lines_of(raw)
    at, size = rng.integers(1, len(lines)), int(rng.choice([2, 20, 3000]))
    part = lines[at : at + size]
    return b"\n".join([*lines[:at], *(part[i] for i in rng.permutation(len(part))), *lines[at + size :]])


def swap_columns(raw: bytes, rng: Rng) -> bytes:
    order, keep_header = rng.permutation(4), int(rng.integers(2))
    rows = [line.split(b",") for line in lines_of(raw)]
    moved = [
        [row[i] for i in order] if len(row) == 4 and n >= keep_header else row for n, row in enumerate(rows)
    ]
    return b"\n".join(b",".join(row) for row in moved)


def other_delimiter(raw: bytes, rng: Rng) -> bytes:
    return raw.replace(b",", [b";", b"\t", b"|", b" ", b", "][rng.integers(5)])


def other_ends(raw: bytes, rng: Rng) -> bytes:
    return raw.replace(b"\n", [b"\r\n", b"\r", b"\n\n"][rng.integers(3)])


def decimal_comma(raw: bytes, rng: Rng) -> bytes:
    return raw.replace(b",", b";").replace(b".", b",")


def other_header(raw: bytes, rng: Rng) -> bytes:
    heads = [
        b"",
        b"time,force,flag,volt",
        b"\xef\xbb\xbfTime,Load Cell,Moving Forward,Relay Output",
        b"Time," * 4000,
    ]
    return heads[rng.integers(len(heads))] + b"\n" + raw.split(b"\n", 1)[-1]


def table_of(raw: bytes) -> np.ndarray:
    return np.array([[float(c) for c in line.split(b",")] for line in lines_of(raw)[1:] if line])


def text_of(table: np.ndarray) -> bytes:
    rows = "\n".join(",".join(map(repr, row)) for row in table.tolist())
    return b"Time,Load Cell,Moving Forward,Relay Output\n" + rows.encode() + b"\n"


def column_hole(raw: bytes, rng: Rng) -> bytes:
    table = table_of(raw)
    column, size = rng.integers(4), int(rng.integers(1, min(6000, len(table) // 3)))
    at = int(rng.integers(0, len(table) - size))
    table[:, column] = np.concatenate([np.delete(table[:, column], slice(at, at + size)), np.zeros(size)])
    return text_of(table)


def lost_character(raw: bytes, rng: Rng) -> bytes:
    lines = lines_of(raw)
    at = rng.integers(1, len(lines) - 1)
    cells = lines[at].split(b",")
    column = rng.integers(len(cells))
    cells[column] = cells[column][1:]
    lines[at] = b",".join(cells)
    return b"\n".join(lines)


def other_numbers(raw: bytes, rng: Rng) -> bytes:
    table = table_of(raw)
    changes: list[Callable[[np.ndarray], np.ndarray]] = [
        lambda t: t * [1e-3, 1, 1, 1],
        lambda t: t * [1e-6, 1, 1, 1],
        lambda t: t[:: int(rng.integers(2, 30))],
        lambda t: t[::-1],
        lambda t: t * [1, 1000.0, 1, 1],
        lambda t: t * [1, 1, 1, 0.1],
        lambda t: t * [1, 0, 1, 1],
        lambda t: t * [0, 1, 1, 1],
        lambda t: t * [1, 1, 3, 1],
        lambda t: np.add(t, [1e9, 0, 0, 0]),
        lambda t: np.where(rng.random(t.shape) < 10 ** rng.uniform(-5, 0), np.nan, t),
        lambda t: np.concatenate([t] * 3),
        lambda t: t[: int(rng.integers(0, 400))],
    ]
    return text_of(changes[rng.integers(len(changes))](table)).replace(b"nan", rng.choice([b"nan", b""]))


MUTATIONS = (
    flip, delete, insert, cut, drop_lines, repeat_lines, merge_lines, shuffle_lines, swap_columns, other_delimiter,
    other_ends, decimal_comma, other_header, column_hole, lost_character, other_numbers,
)  # fmt: skip


def mutated(raw: bytes, rng: Rng) -> tuple[str, bytes, str]:
    """Name of the mutation, the file's bytes, its extension."""
    extension = str(rng.choice([".csv", ".csv", ".csv", ".csv.gz", ".csv.xz", ".npy"]))
    pack = {".csv.gz": lambda r: gzip.compress(r, 1), ".csv.xz": lambda r: lzma.compress(r, preset=0)}.get(
        extension
    )
    change = MUTATIONS[rng.integers(len(MUTATIONS))]
    if extension == ".npy":
        with tempfile.TemporaryFile() as stream:
            np.save(stream, table_of(raw))
            stream.seek(0)
            change = [flip, delete, insert, cut][rng.integers(4)]
            return f"npy_{change.__name__}", change(stream.read(), rng), extension
    if pack and rng.random() < 0.5:
        change = [flip, delete, insert, cut][rng.integers(4)]
        return f"packed_{change.__name__}", change(pack(raw), rng), extension
    changed = change(raw, rng)
    return change.__name__, pack(changed) if pack else changed, extension


def judge(path: Path, base: dict) -> str:
    """What became of a mutated log."""
    try:
        found = extract(read_log(path), BENCH)
    except InputError as error:
        clear = path.name in str(error) and "\n" not in str(error)
        return "clear_error" if clear else "unclear_error"
    new = set(found["flags"].split(";")) - set(base["flags"].split(";")) - {""}
    if new:
        return "flagged"
    for name in OBSERVABLES:
        before, after = base[name], found[name]
        sd = np.hypot(base[f"{name}_sd"], found[f"{name}_sd"])
        if np.isfinite(after) and not (np.isfinite(before) and abs(after - before) <= LIMIT * sd):
            return "silently_wrong"
    return "right"


def run(count: int, seed: int) -> dict:
    """Try ``count`` mutated logs; returns the record."""
    rng = np.random.default_rng(seed)
    outcomes: dict[str, Counter] = {}
    kept, slowest = [], 0.0
    with tempfile.TemporaryDirectory() as place:
        bases = []
        for made in (SHORT, TINY):
            recording = make_run(made, rng)[0]
            path = write_log(recording, Path(place) / f"{recording.settings.run}.csv")
            bases.append((recording.settings.run, path.read_bytes(), extract(read_log(path), BENCH)))
        for number in range(count):
            name, raw, base = bases[int(rng.random() < TINY_SHARE)]
            mutation, content, extension = mutated(raw, rng)
            path = Path(place) / f"{name}{extension}"
            path.write_bytes(content)
            start = time.perf_counter()
            try:
                outcome = judge(path, base)
            except Exception:
                outcome = "traceback"
                kept.append(traceback.format_exc().splitlines()[-3:])
            slowest = max(slowest, time.perf_counter() - start)
            outcomes.setdefault(mutation, Counter())[outcome] += 1
            if outcome in ("silently_wrong", "unclear_error"):
                kept.append([mutation, number, outcome])
            path.unlink()
    total = sum(outcomes.values(), Counter())
    return {
        "logs": count,
        "seed": seed,
        "share_of_tiny_logs": TINY_SHARE,
        "outcomes": dict(total),
        "by_mutation": {name: dict(found) for name, found in sorted(outcomes.items())},
        "slowest_s": round(slowest, 3),
        "to_mend": kept[:50],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path)
    chosen = parser.parse_args()
    record = run(chosen.count, chosen.seed)
    head = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False
    )
    record |= {
        "command": f"python tests/rig/fuzz_logs.py --count {chosen.count} --seed {chosen.seed} --output <file>",
        "date": date.today().isoformat(),
        "commit": head.stdout.strip(),
    }
    text = json.dumps(record, indent=1, sort_keys=True)
    print(text)
    if chosen.output:
        chosen.output.write_text(text + "\n")


if __name__ == "__main__":
    main()
