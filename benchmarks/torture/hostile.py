"""Campaigns that want to do harm, each as a folder: code in data, bombs, names and links that lead elsewhere.

    python benchmarks/torture/hostile.py --output docs/measurements/hostile.json

Each goes through the commands that read a campaign. Nothing may execute (a canary file would tell), nothing may be
written outside the results, memory and time stay bounded, and what is refused is refused in one line.
"""

from __future__ import annotations

import argparse
import functools
import gzip
import io
import json
import lzma
import os
import pickle
import resource
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np
from openpyxl import Workbook

from eaclutch.files import write_json
from eaclutch.provenance import commit

NAME = "20250101_10_00_00_bts_dx=1.5_v=0.5_Fpre=-1g_V=300_f=1000_w=2_brass"
HEADER = "Time,Load Cell,Moving Forward,Relay Output\n"
CASES: dict[str, Callable[[Path], None]] = {}
BOMB_MEGABYTES = 1500
MEMORY_LIMIT = 1 << 30  # bytes resident
TIME_LIMIT = 60.0  # s a command


def case(build: Callable[[Path], None]) -> Callable[[Path], None]:
    """Register a hostile campaign under its function's name."""
    CASES[build.__name__] = build
    return build


def sound_log(rows: int = 20_000) -> str:
    """A log that is one, so that the rest of a campaign gets read."""
    time_us = 800 + 78 * np.arange(rows)
    flag = ((time_us > 3e5) & (time_us < 1.2e6)).astype(float)
    force = 0.1 + 0.5 * flag
    lines = [
        f"{t}.0,{f!r},{g!r},{300 * g!r}"
        for t, f, g in zip(time_us, force.tolist(), flag.tolist(), strict=True)
    ]
    return HEADER + "\n".join(lines) + "\n"


def base(folder: Path, facts: str = "name: hostile\n", log: bool = True) -> Path:
    """A campaign folder with facts and one sound log."""
    for part in ("tensile", "capacitance", "permittivity", "load_cell"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    (folder / "campaign.yaml").write_text(facts)
    if log:
        (folder / "tensile" / f"{NAME}.csv").write_text(sound_log())
    return folder


class _Bomb:
    """Unpickled, it makes the canary."""

    def __reduce__(self):
        return os.system, ("touch canary",)


@case
def npy_pickle(folder: Path) -> None:
    base(folder, log=False)
    with (folder / "tensile" / f"{NAME}.npy").open("wb") as stream:
        np.save(stream, np.array([_Bomb()] * 8, dtype=object).reshape(2, 4), allow_pickle=True)


@case
def npy_is_a_pickle(folder: Path) -> None:
    base(folder, log=False)
    (folder / "tensile" / f"{NAME}.npy").write_bytes(pickle.dumps(_Bomb()))


@case
def npy_absurd_shape(folder: Path) -> None:
    base(folder, log=False)
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (400000, 4), }".ljust(117) + b"\n"
    raw = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + b"\0" * 64
    (folder / "tensile" / f"{NAME}.npy").write_bytes(raw)


@case
def npy_header_with_code(folder: Path) -> None:
    base(folder, log=False)
    header = (
        b"{'descr': '<f8', 'fortran_order': __import__('os').system('touch canary'), 'shape': (200, 4)}\n"
    )
    (folder / "tensile" / f"{NAME}.npy").write_bytes(
        b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + b"\0" * 6400
    )


@case
def yaml_python_tag(folder: Path) -> None:
    base(folder, 'name: !!python/object/apply:os.system ["touch canary"]\n')


@case
def yaml_aliases(folder: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 12)]
    base(folder, "\n".join(lines) + "\n")


@case
def yaml_deep(folder: Path) -> None:
    base(folder, "name: " + "[" * 100_000 + "]" * 100_000 + "\n")


@case
def yaml_runs_python_in_configs(folder: Path) -> None:
    base(folder, "__use_yte__: true\n__definitions__:\n  - import os; os.system('touch canary')\n")


@case
def yaml_name_leads_elsewhere(folder: Path) -> None:
    base(folder, "name: ../../elsewhere\n")


@case
def yaml_not_finite(folder: Path) -> None:
    base(folder, "film: {density_kg_m3: .inf}\nfriction: {film: {static: [.nan, 1.0]}}\n")


@case
def yaml_absurd_numbers(folder: Path) -> None:
    base(folder, "pad: {electrodes: 999999999999999999999999}\n")


@case
def yaml_reason_with_html(folder: Path) -> None:
    base(folder, f"exclude: {{'../../{NAME}': '<script>alert(1)</script>'}}\n")


def _bomb(folder: Path, extension: str, opener: Callable) -> None:
    base(folder, log=False)
    chunk = b"1.0,0.0,0.0,0.0\n" * 65536
    with opener(folder / "tensile" / f"{NAME}.csv.{extension}", "wb") as stream:
        stream.write(HEADER.encode())
        for _ in range(BOMB_MEGABYTES):
            stream.write(chunk)


@case
def gz_bomb(folder: Path) -> None:
    _bomb(folder, "gz", functools.partial(gzip.open, compresslevel=1))


@case
def xz_bomb(folder: Path) -> None:
    _bomb(folder, "xz", functools.partial(lzma.open, preset=0))


@case
def csv_one_endless_line(folder: Path) -> None:
    base(folder, log=False)
    (folder / "tensile" / f"{NAME}.csv").write_text(HEADER + "1," * 20_000_000)


@case
def csv_endless_cells(folder: Path) -> None:
    base(folder, log=False)
    (folder / "tensile" / f"{NAME}.csv").write_text(HEADER + ("9" * 100_000 + ",0,0,0\n") * 300)


@case
def csv_all_nan(folder: Path) -> None:
    base(folder, log=False)
    (folder / "tensile" / f"{NAME}.csv").write_text(HEADER + "nan,nan,nan,nan\n" * 20_000)


@case
def csv_infinities(folder: Path) -> None:
    base(folder, log=False)
    rows = sound_log().splitlines()
    for i in range(1000, 1010):
        rows[i] = "inf,-inf,1e400,NaN"
    (folder / "tensile" / f"{NAME}.csv").write_text("\n".join(rows) + "\n")


@case
def csv_nul_bytes(folder: Path) -> None:
    base(folder, log=False)
    (folder / "tensile" / f"{NAME}.csv").write_bytes(sound_log().encode().replace(b"7", b"\0"))


@case
def csv_empty(folder: Path) -> None:
    base(folder, log=False)
    (folder / "tensile" / f"{NAME}.csv").write_bytes(b"")


@case
def name_with_html(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME}<img src=x onerror=alert(1)>.csv").write_text(sound_log())


@case
def name_with_shell(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME[:-5]}$(touch canary)`touch canary`;touch canary;.csv").write_text(
        sound_log()
    )


@case
def name_with_newline(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME}\neaclutch: error: nothing is wrong.csv").write_text(sound_log())


@case
def name_with_absurd_numbers(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME.replace('V=300', 'V=1e999')}.csv").write_text(sound_log())


@case
def side_file_with_shell_name(folder: Path) -> None:
    base(folder)
    text = "force_n,capacitance_pf,width_mm,trial\n" + "0.1,20,2,$(touch canary)\n0.2,21,2,<script>\n"
    (folder / "capacitance" / "a;touch canary;$(touch canary).csv").write_text(text)


@case
def log_is_a_link_out(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME.replace('10_00_00', '11_00_00')}.csv").symlink_to("/etc/passwd")


@case
def folder_is_a_link_out(folder: Path) -> None:
    base(folder, log=False)
    other = folder.with_name("other")
    base(other)
    (folder / "tensile").rmdir()
    (folder / "tensile").symlink_to(other / "tensile")


@case
def facts_are_a_link_out(folder: Path) -> None:
    base(folder)
    (folder / "campaign.yaml").unlink()
    (folder / "campaign.yaml").symlink_to("/etc/passwd")


@case
def link_to_itself(folder: Path) -> None:
    base(folder)
    path = folder / "tensile" / f"{NAME.replace('10_00_00', '11_00_00')}.csv"
    path.symlink_to(path)


@case
def log_is_a_pipe(folder: Path) -> None:
    base(folder)
    os.mkfifo(folder / "tensile" / f"{NAME.replace('10_00_00', '11_00_00')}.csv")
    os.mkfifo(folder / "capacitance" / "pipe.csv")


@case
def facts_are_a_pipe(folder: Path) -> None:
    base(folder)
    (folder / "campaign.yaml").unlink()
    os.mkfifo(folder / "campaign.yaml")


@case
def log_is_a_folder(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME.replace('10_00_00', '11_00_00')}.csv").mkdir()


def _workbook(folder: Path, change: Callable[[zipfile.ZipFile, zipfile.ZipFile], None]) -> None:
    base(folder)
    book = Workbook()
    sheet = book.active
    sheet.title = "w=2mm (1)"
    sheet.append(["Force (N)", "Capacitance (pF)"])
    for i in range(50):
        sheet.append([0.1 * i, 20 + i])
    plain = io.BytesIO()
    book.save(plain)
    with (
        zipfile.ZipFile(plain) as before,
        zipfile.ZipFile(folder / "capacitance" / "book.xlsx", "w", zipfile.ZIP_DEFLATED) as after,
    ):
        change(before, after)


def _sheet(before: zipfile.ZipFile, after: zipfile.ZipFile, edit: Callable[[bytes], bytes]) -> None:
    for item in before.namelist():
        data = before.read(item)
        after.writestr(item, edit(data) if item.endswith("sheet1.xml") else data)


@case
def workbook_formula_without_value(folder: Path) -> None:
    formula = b'<c r="A3"><f>WEBSERVICE("http://127.0.0.1/")</f></c>'
    _workbook(
        folder, lambda b, a: _sheet(b, a, lambda d: d.replace(b'<c r="A3" t="n"><v>0.1</v></c>', formula))
    )


@case
def workbook_formula_runs_a_program(folder: Path) -> None:
    formula = b"<c r=\"A3\"><f>cmd|'/c touch canary'!A1</f><v>0.1</v></c>"
    _workbook(
        folder, lambda b, a: _sheet(b, a, lambda d: d.replace(b'<c r="A3" t="n"><v>0.1</v></c>', formula))
    )


@case
def workbook_laughs(folder: Path) -> None:
    entities = b'<!ENTITY a0 "ha">' + b"".join(
        b'<!ENTITY a%d "%s">' % (i, b"&a%d;" % (i - 1) * 10) for i in range(1, 10)
    )

    def edit(data: bytes) -> bytes:
        head, body = data.split(b"?>", 1) if data.startswith(b"<?xml") else (b'<?xml version="1.0"', data)
        body = body.replace(b"<v>0.1</v>", b"<v>&a9;</v>")
        return head + b"?><!DOCTYPE w [" + entities + b"]>" + body

    _workbook(folder, lambda b, a: _sheet(b, a, edit))


@case
def workbook_reads_a_file(folder: Path) -> None:
    def edit(data: bytes) -> bytes:
        entity = b'<!DOCTYPE w [<!ENTITY x SYSTEM "file:///etc/passwd">]>'
        return entity + data.replace(b"<v>0.1</v>", b"<v>&x;</v>")

    _workbook(folder, lambda b, a: _sheet(b, a, edit))


@case
def workbook_external_link(folder: Path) -> None:
    def change(before: zipfile.ZipFile, after: zipfile.ZipFile) -> None:
        _sheet(before, after, lambda data: data)
        target = b'Target="file:///etc/passwd" TargetMode="External"'
        after.writestr(
            "xl/externalLinks/_rels/externalLink1.xml.rels",
            b'<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
            b'<Relationship Id="rId1" '
            b'Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/externalLinkPath" ' + target
            + b"/></Relationships>",
        )  # fmt: skip

    _workbook(folder, change)


@case
def workbook_bomb(folder: Path) -> None:
    def change(before: zipfile.ZipFile, after: zipfile.ZipFile) -> None:
        _sheet(before, after, lambda data: data)
        with after.open("xl/worksheets/sheet2.xml", "w", force_zip64=True) as stream:
            for _ in range(BOMB_MEGABYTES // 3):
                stream.write(b" " * (1 << 20))

    _workbook(folder, change)


@case
def workbook_endless_rows(folder: Path) -> None:
    def edit(data: bytes) -> bytes:
        row = b'<row r="1048576"><c r="A1048576" t="n"><v>1</v></c></row></sheetData>'
        return data.replace(b"</sheetData>", row)

    _workbook(folder, lambda b, a: _sheet(b, a, edit))


@case
def spectrum_not_finite(folder: Path) -> None:
    base(folder)
    (folder / "permittivity" / "s.csv").write_text(
        "frequency_hz,relative_permittivity\n1,inf\n-5,nan\n0,1e400\n"
    )


@case
def capacitance_not_finite(folder: Path) -> None:
    base(folder)
    text = "force_n,capacitance_pf,width_mm,trial\n" + "nan,inf,2,a\n1e308,1e-320,0,a\n" * 10
    (folder / "capacitance" / "c.csv").write_text(text)


@case
def load_cell_not_finite(folder: Path) -> None:
    base(folder)
    text = "Time,Load Cell,Moving Forward\n" + "nan,inf,-inf\n" * 65_000
    (folder / "load_cell" / "20250101_10_00_00_calibrate_loadcell_damper_dx=1_speed=1mms.csv").write_text(
        text
    )


@case
def record_of_capture_is_nested(folder: Path) -> None:
    base(folder)
    (folder / "capture").mkdir()
    (folder / "capture" / f"{NAME}.json").write_text("[" * 90_000)


COMMANDS = (
    ("capture-check", "--campaign", "{campaign}", "--output", "capture.json"),
    ("observables", "--campaign", "{campaign}", "--capture", "capture.json", "--batch", "0", "--output", "batch.csv",
     "--published", "published.csv", "--traces", "traces.npz"),
    ("gap", "--campaign", "{campaign}", "--gap", "gap.csv", "--spectra", "spectra.csv", "--bursts", "bursts.csv"),
)  # fmt: skip


def run(build: Callable[[Path], None]) -> dict:
    """What became of one hostile campaign."""
    with tempfile.TemporaryDirectory() as place:
        folder, results = Path(place, "campaign"), Path(place, "work", "results")
        results.mkdir(parents=True)
        build(folder)
        before = _state(folder)
        outcome, peak, slowest, faults = "read", 0, 0.0, []
        for command in COMMANDS:
            arguments = [part.format(campaign=folder) for part in command]
            started = time.monotonic()
            try:
                done = subprocess.run(
                    [sys.executable, "-m", "eaclutch", *arguments],
                    cwd=results, capture_output=True, text=True, timeout=TIME_LIMIT,
                )  # fmt: skip
            except subprocess.TimeoutExpired:
                faults.append(f"{command[0]} hangs")
                break
            slowest = max(slowest, time.monotonic() - started)
            peak = max(peak, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024)
            if done.returncode:
                lines = done.stderr.splitlines()
                if len(lines) != 1 or not lines[0].startswith("eaclutch: error: "):
                    faults.append(f"{command[0]}: {lines[-1:]}")
                outcome = f"refused by {command[0]}: {lines[-1][16:].replace(place, '') if lines else ''}"
                break
        if list(Path(place).rglob("canary")) or Path("canary").exists():
            faults.append("executed")
        if _state(folder) != before:
            faults.append("campaign changed")
        stray = {path.name for path in Path(place).iterdir()} - {"campaign", "other", "work"}
        if stray or {path.name for path in Path(place, "work").iterdir()} != {"results"}:
            faults.append("wrote outside the results")
    return {"outcome": outcome, "faults": faults, "peak_bytes": peak, "slowest_s": slowest}


def _state(folder: Path) -> list[tuple[str, int]]:
    return sorted((str(path), path.lstat().st_mtime_ns) for path in folder.rglob("*"))


def main() -> None:
    """Run all cases, or those named, and write what came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("cases", nargs="*")
    chosen = parser.parse_args()
    found = {}
    for name, build in CASES.items():
        if not chosen.cases or name in chosen.cases:
            found[name] = run(build)
            print(name, json.dumps(found[name]), flush=True)
    # peak_bytes is the largest child so far: what counts is that none goes beyond the limit
    peak = max(entry.pop("peak_bytes") for entry in found.values())
    result = {
        "command": f"python benchmarks/torture/hostile.py --output {chosen.output}",
        "date": date.today().isoformat(),
        "commit": commit(),
        "peak_bytes": peak,
        "faults": sum(len(entry["faults"]) for entry in found.values()) + (peak > MEMORY_LIMIT),
        "cases": found,
    }
    write_json(chosen.output, result)
    sys.exit(bool(result["faults"]))


if __name__ == "__main__":
    main()
