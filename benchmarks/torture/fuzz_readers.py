"""Every reader of what a campaign or an operator brings, each with a sound file to mutate."""

from __future__ import annotations

import gzip
import io
import lzma
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from hostile_campaigns import workbooks
from hostile_campaigns.sound import NAME, sound_log

from eaclutch.config import load_bench, load_config
from eaclutch.records import Bench, Substrate
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.capacitance import read_capacitance
from eaclutch.rig.extract import extract
from eaclutch.rig.link.plan import read_plan
from eaclutch.rig.link.protocol import BenchSetting, Command, on_the_grid, render
from eaclutch.rig.link.store import columns_of, missing_slots
from eaclutch.rig.link.synthetic import SHORT, SyntheticBench
from eaclutch.rig.link.transfer import parse_transfer
from eaclutch.rig.load_cell import read_bursts
from eaclutch.rig.log_names import parse_log_name
from eaclutch.rig.logs import read_log
from eaclutch.rig.spectra import read_spectra

ROOT = Path(__file__).resolve().parents[2]


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
    text = sound_log(3000)
    table = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1)
    npy = io.BytesIO()
    np.save(npy, table, allow_pickle=False)
    with tempfile.TemporaryDirectory() as place:
        workbooks.workbook_formula_runs_a_program(Path(place))
        book = Path(place, "capacitance", "book.xlsx").read_bytes()
    with zipfile.ZipFile(io.BytesIO(book)) as archive:
        sheet = archive.read("xl/worksheets/sheet1.xml")

    def repacked(content: bytes) -> bytes:
        packed = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(book)) as before, zipfile.ZipFile(packed, "w") as after:
            workbooks.rewrite_sheet(before, after, lambda _: content)
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
