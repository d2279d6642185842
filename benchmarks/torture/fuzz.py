"""Fuzzing of every reader: sound files, mutated; whatever comes must end in a result or in one InputError.

    python benchmarks/torture/fuzz.py --minutes 60 --output docs/measurements/fuzz.json

A failure names its reader and number; ``--only <reader> --first <number> --count 1`` repeats it.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from datetime import date
from pathlib import Path

import numpy as np
from fuzz_readers import Reader, readers
from hostile_campaigns.sound import NAME

from eaclutch.files import write_json
from eaclutch.provenance import commit
from eaclutch.records import InputError
from eaclutch.rig.link.transfer import TransferFault

TOKENS = [
    b"nan", b"inf", b"-inf", b"1e400", b"-0", b"1_000", b"\0", b"\xff\xfe", b"\r", b"\n", b",", b",,", b'"', b"&a *a",
    b"!!python/object/apply:os.system [true]", b"{", b"[", b": ", b"- ", b"9" * 400, b"0x10", b"true", b"~",
    b"\xef\xbb\xbf", b"<script>", b"../", b"{}", b"[]", b"1e-320", b"-1", b"1e18", b" ",
]  # fmt: skip


def mutate(content: bytes, rng: np.random.Generator) -> bytes:
    """One to four changes: bits, bytes, pieces lost, doubled or moved, tokens that parsers stumble over."""
    data = bytearray(content)
    for _ in range(int(rng.integers(1, 5))):
        n = len(data)
        at = int(rng.integers(0, n + 1))
        length = int(min(n - at, 2 ** rng.integers(0, 12)))
        match int(rng.integers(0, 7)):
            case 0 if n > at:
                data[at] ^= 1 << int(rng.integers(0, 8))
            case 1:
                data[at : at + length] = rng.integers(0, 256, min(length, 16), dtype=np.uint8).tobytes()
            case 2:
                del data[at : at + length]
            case 3:
                data[at:at] = data[at : at + length]
            case 4:
                data = data[:at]
            case 5:
                data[at : at + int(rng.integers(0, 4))] = TOKENS[int(rng.integers(len(TOKENS)))]
            case _:
                piece = data[at : at + length]
                del data[at : at + length]
                where = int(rng.integers(0, len(data) + 1))
                data[where:where] = piece
    return bytes(data)


def trial(name: str, reader: Reader, number: int, folder: Path) -> str:
    """Outcome of one mutation: read, refused, or the traceback's last words."""
    rng = np.random.default_rng([number, *name.encode()])
    for part in ("tensile", "capacitance", "permittivity", "load_cell", "capture"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    if reader.path.split("/")[0] not in ("tensile", "campaign.yaml"):
        (folder / "tensile" / f"{NAME}.csv").write_text("Time\n")
    if reader.path != "campaign.yaml":
        (folder / "campaign.yaml").write_text("name: fuzz\n")
    (folder / reader.path).write_bytes(reader.wrap(mutate(reader.content, rng)))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            reader.read(folder)
    except (InputError, TransferFault) as refused:
        return "refused" if "\n" not in str(refused) else f"FAULT: {refused!r}"
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        own = [frame for frame in frames if "eaclutch" in frame.filename][-1]
        return f"FAULT: {error!r} at {Path(own.filename).name}:{own.lineno}"
    return "read"


def main() -> None:
    """Fuzz for so many minutes, or so many trials of one reader."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--count", type=int, help="trials of each reader, instead of minutes")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only")
    parser.add_argument("--output", type=Path, required=True)
    chosen = parser.parse_args()
    known = {name: reader for name, reader in readers().items() if chosen.only in (None, name)}
    tally: dict[str, Counter] = {name: Counter() for name in known}
    faults: dict[str, list[str]] = {}
    slowest = dict.fromkeys(known, 0.0)
    started, number = time.monotonic(), chosen.first
    while (
        (number < chosen.first + chosen.count)
        if chosen.count
        else (time.monotonic() - started < 60 * chosen.minutes)
    ):
        for name, reader in known.items():
            with tempfile.TemporaryDirectory() as place:
                before = time.monotonic()
                outcome = trial(name, reader, number, Path(place))
                slowest[name] = max(slowest[name], time.monotonic() - before)
            tally[name][outcome.split(":")[0]] += 1
            if outcome.startswith("FAULT"):
                faults.setdefault(outcome.replace(place, ""), []).append(f"{name} {number}")
        number += 1
    result = {
        "command": " ".join(["python benchmarks/torture/fuzz.py", *sys.argv[1:]]),
        "date": date.today().isoformat(),
        "commit": commit(),
        "minutes": (time.monotonic() - started) / 60,
        "trials_each": number - chosen.first,
        "outcomes": {name: dict(sorted(counts.items())) for name, counts in tally.items()},
        "slowest_s": slowest,
        "faults": {what: {"count": len(where), "first": where[0]} for what, where in faults.items()},
    }
    write_json(chosen.output, result)
    print(json.dumps(result, indent=1))
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
