"""Fuzzing of every reader: sound files, mutated; whatever comes must end in a result or in one InputError.

    python benchmarks/torture/fuzz.py --minutes 60 --output docs/measurements/fuzz.json

A failure names its reader and number; ``--only <reader> --first <number> --count 1`` repeats it.
"""

from __future__ import annotations

import argparse
import gzip
import importlib.util
import io
import json
import lzma
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np

from eaclutch.config import load_bench, load_config
from eaclutch.files import write_json
from eaclutch.provenance import commit
from eaclutch.records import Bench, InputError, Substrate
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.capacitance import read_capacitance
from eaclutch.rig.extract import extract
from eaclutch.rig.link.plan import read_plan
from eaclutch.rig.link.protocol import BenchSetting, Command, on_the_grid, render
from eaclutch.rig.link.store import columns_of, missing_slots
from eaclutch.rig.link.synthetic import SHORT, SyntheticBench
from eaclutch.rig.link.transfer import TransferFault, parse_transfer
from eaclutch.rig.load_cell import read_bursts
from eaclutch.rig.log_names import parse_log_name
from eaclutch.rig.logs import read_log
from eaclutch.rig.spectra import read_spectra

_SPEC = importlib.util.spec_from_file_location("hostile", Path(__file__).with_name("hostile.py"))
hostile = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(hostile)
NAME = hostile.NAME
ROOT = Path(__file__).resolve().parents[2]
TOKENS = [
    b"nan", b"inf", b"-inf", b"1e400", b"-0", b"1_000", b"\0", b"\xff\xfe", b"\r", b"\n", b",", b",,", b'"', b"&a *a",
    b"!!python/object/apply:os.system [true]", b"{", b"[", b": ", b"- ", b"9" * 400, b"0x10", b"true", b"~",
    b"\xef\xbb\xbf", b"<script>", b"../", b"{}", b"[]", b"1e-320", b"-1", b"1e18", b" ",
]  # fmt: skip


@dataclass(frozen=True)
class Reader:
    """A sound file, where it goes in a campaign, and what reads it."""

    path: str
    content: bytes
    read: Callable[[Path], object]
    wrap: Callable[[bytes], bytes] = bytes  # what packs the mutated content


def _bench() -> Bench:
    return Bench("fuzz", substrates={"brass": Substrate(thickness={2e-3: 2e-3})})


def _extract(folder: Path) -> object:
    path = next((folder / "tensile").iterdir())
    return extract(read_log(path), _bench())


def readers() -> dict[str, Reader]:
    """All readers of what a campaign or an operator brings."""
    text = hostile.sound_log(3000)
    table = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1)
    npy = io.BytesIO()
    np.save(npy, table, allow_pickle=False)
    with tempfile.TemporaryDirectory() as place:
        hostile.workbook_formula_runs_a_program(Path(place))
        book = Path(place, "capacitance", "book.xlsx").read_bytes()
    with zipfile.ZipFile(io.BytesIO(book)) as archive:
        sheet = archive.read("xl/worksheets/sheet1.xml")

    def repacked(content: bytes) -> bytes:
        packed = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(book)) as before, zipfile.ZipFile(packed, "w") as after:
            hostile._sheet(before, after, lambda _: content)
        return packed.getvalue()

    rng = np.random.default_rng(1)
    reply = render(
        on_the_grid(
            columns_of(
                SyntheticBench(rng, SHORT)(BenchSetting(300.0, 1e3, 2e-3, "brass"), Command(2e-4, 2e-3))
            )
        )
    )
    capacitance = "force_n,capacitance_pf,width_mm,trial\n" + "".join(
        f"{0.1 * i},{20 + i},2,a\n" for i in range(40)
    )
    burst = "Time,Load Cell,Moving Forward\n" + "".join(
        f"{78 * i},{0.07 * np.sin(0.32 * i) * np.exp(-(i % 600) / 90):.8f},{i // 600 % 2}\n"
        for i in range(6000)
    )
    facts = (
        "name: fuzz\npad: {type: interdigitated, electrodes: 28}\nsubstrates: {brass: {density_kg_m3: 8049, "
        "thickness_mm: {2: 2, 2.5: 2.5}}}\nfriction: {base: {static: [0.281, 0.034]}}\nsessions:\n"
        "  - {name: a, from: 2024-11-03, to: 2024-11-04}\nexclude: {" + NAME + ": odd}\n"
    )
    log = f"tensile/{NAME}"

    def campaign(function: Callable) -> Callable[[Path], object]:
        return lambda folder: function(open_campaign(folder))

    return {
        "log_csv": Reader(f"{log}.csv", text.encode(), _extract),
        "log_gz": Reader(f"{log}.csv.gz", gzip.compress(text.encode(), 1), _extract),
        "log_xz": Reader(f"{log}.csv.xz", lzma.compress(text.encode(), preset=0), _extract),
        "log_npy": Reader(f"{log}.npy", npy.getvalue(), _extract),
        "facts": Reader("campaign.yaml", facts.encode(), load_bench),
        "workbook": Reader("capacitance/book.xlsx", book, campaign(read_capacitance)),
        "workbook_sheet": Reader("capacitance/book.xlsx", sheet, campaign(read_capacitance), repacked),
        "capacitance": Reader("capacitance/c.csv", capacitance.encode(), campaign(read_capacitance)),
        "spectrum": Reader("permittivity/s.csv", b"1,50\n10,49.5\n100,48\n1e5,30.5\n", campaign(read_spectra)),
        "load_cell": Reader(
            "load_cell/20250101_10_00_00_calibrate_loadcell_damper_dx=1_speed=1mms.csv",
            burst.encode(), campaign(read_bursts),
        ),
        "record": Reader(
            f"capture/{NAME}.json", b'{"plan": "p", "run": "x", "repeat": 1}',
            lambda folder: missing_slots(read_plan(ROOT / "config" / "plan.yaml"), folder),
        ),
        "plan": Reader(
            "plan.yaml", (ROOT / "config" / "plan.yaml").read_bytes(), lambda folder: read_plan(folder / "plan.yaml")
        ),
        "config": Reader(
            "config.yaml", (ROOT / "config" / "rig.yaml").read_bytes() + b"seed: 3\nposterior: {walkers: 32}\n",
            lambda folder: load_config([folder / "config.yaml"]),
        ),
        "name": Reader(
            "name", NAME.encode(), lambda folder: parse_log_name((folder / "name").read_bytes().decode("latin-1"))
        ),
        "reply": Reader("reply", reply, lambda folder: parse_transfer((folder / "reply").read_bytes(), SHORT)),
    }  # fmt: skip


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
