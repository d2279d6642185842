"""Capacitance readings, spectra, load-cell bursts: all files joined, bad ones refused with file and row."""

from __future__ import annotations

import numpy as np
import pytest
from openpyxl import Workbook

from eaclutch.records import Bench, Campaign, InputError
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.capacitance import read_capacitance
from eaclutch.rig.gap import gap_from_capacitance, gap_table
from eaclutch.rig.load_cell import read_bursts
from eaclutch.rig.spectra import read_spectra

BENCH = Bench("test")


def campaign(folder, **files):
    kinds = ("capacitance", "permittivity", "load_cell")
    return Campaign(folder, BENCH, (), *(tuple(files.get(kind, ())) for kind in kinds))


def workbook(path, *, formula=False, text=False):
    book = Workbook()
    sheet = book.active
    sheet.title = "w=2.5 (20241002)"
    sheet.append(["Force (N)", "Capacitance (pF)", "Gap (um)", None, "Capacitance (pF)"])
    sheet.append([0.1, 14.5, "=1/B2", None, 4.0])
    sheet.append([0.5, "=E3+10.5" if formula else ("x" if text else 18.0), None, None, 7.5])
    sheet.append([None, None, None, None, 3.0])
    book.create_sheet("notes").append(["w", 3])
    book.save(path)
    return path


def test_csv_and_workbook_are_joined(tmp_path):
    csv = tmp_path / "bench.csv"
    csv.write_text("trial,force_n,capacitance_pf,width_mm\n1,0.2,10,2\n2,0.3,11,2\n1,0.2,20,3\n")
    found = read_capacitance(campaign(tmp_path, capacitance=[csv, workbook(tmp_path / "lab.xlsx")]))
    assert np.allclose(found.force, [0.2, 0.2, 0.3, 0.1, 0.5])
    assert np.allclose(found.capacitance * 1e12, [10, 20, 11, 14.5, 18.0])
    assert np.allclose(found.width * 1e3, [2, 3, 2, 2.5, 2.5])
    assert len(set(found.trial)) == 4 and set(found.source) == {"bench", "lab"}


def test_formulas_are_never_evaluated(tmp_path):
    with pytest.raises(InputError, match=r"lab.xlsx.*row 3.*no cached value"):
        read_capacitance(campaign(tmp_path, capacitance=[workbook(tmp_path / "lab.xlsx", formula=True)]))
    with pytest.raises(InputError, match=r"row 3.*not a number"):
        read_capacitance(campaign(tmp_path, capacitance=[workbook(tmp_path / "lab.xlsx", text=True)]))
    (tmp_path / "bad.xlsx").write_bytes(b"PK\x03\x04 no workbook")
    with pytest.raises(InputError, match=r"bad.xlsx"):
        read_capacitance(campaign(tmp_path, capacitance=[tmp_path / "bad.xlsx"]))


@pytest.mark.parametrize(
    ("text", "row"),
    [
        ("force_n,capacitance_pf,width_mm\n0.1,10,2\n", "row 1"),
        ("force_n,capacitance_pf,width_mm,trial\n0.1,ten,2,1\n", "row 2"),
        ("force_n,capacitance_pf,width_mm,trial\n0.1,10,2,1\n0.1,-3,2,1\n", "row 3"),
        ("force_n,capacitance_pf,width_mm,trial\n0.1,10\n", "row 2"),
        ("", "empty"),
    ],
)
def test_bad_readings_name_their_row(tmp_path, text, row):
    path = tmp_path / "bench.csv"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        read_capacitance(campaign(tmp_path, capacitance=[path]))
    assert "bench.csv" in str(error.value) and row in str(error.value)


def test_spectra_with_and_without_header(tmp_path):
    one, two = tmp_path / "wang.csv", tmp_path / "maker.csv"
    one.write_text("1e4, 50\n1e3, 53\n")
    two.write_text("frequency_hz,relative_permittivity\n1000,53.2\n")
    first, second = read_spectra(campaign(tmp_path, permittivity=[one, two]))
    assert first.source == "wang" and np.allclose(first.frequency, [1e3, 1e4])
    assert np.allclose(first.permittivity, [53, 50]) and len(second.frequency) == 1
    two.write_text("1000,53.2\n2000,0.2\n")
    with pytest.raises(InputError, match=r"maker.csv, row 2"):
        read_spectra(campaign(tmp_path, permittivity=[two]))


def test_gap_follows_its_formula():
    """h = N eps0 A / (4 C) - T_d / kappa for 28 electrodes of 1.5 mm x 2 mm at 20 pF, worked by hand."""
    assert gap_from_capacitance(20e-12, 2e-3, 50.0, BENCH) == pytest.approx(9.2968970e-6 - 0.48e-6, rel=1e-6)
    table = gap_table(
        read_capacitance(campaign(None)), BENCH, widths=[2e-3], force_max=4.0
    )  # no readings: headers only
    assert list(table) == [
        "source", "trial", "width_mm", "force_n", "capacitance_pf", "gap_um", "used", "reason"
    ]  # fmt: skip


def test_bursts_give_frequency_and_damping(tmp_path):
    rng = np.random.default_rng(0)
    time = np.arange(25_000) * 78.125e-6
    force = 0.0108 * rng.standard_normal(len(time))
    for start in (0.3, 0.8, 1.3):
        since = np.maximum(time - start, 0.0)
        w = 2 * np.pi * 645.0
        force += 0.12 * (time > start) * np.exp(-0.02 * w * since) * np.sin(w * since)
    path = tmp_path / "20241029_14_28_31_calibrate_loadcell_damper_dx=0.1_speed=6mms.csv"
    rows = zip(np.floor(time * 1e6), force, strict=True)
    path.write_text("Time,Load Cell,Moving Forward\n" + "".join(f"{t},{f:.8f},1.0\n" for t, f in rows))
    found = read_bursts(campaign(tmp_path, load_cell=[path]))
    assert len(found.frequency) == 3
    assert np.all(np.abs(found.frequency - 645) < 4 * found.frequency_sd)
    assert np.all(np.abs(found.damping_ratio - 0.02) < 4 * found.damping_ratio_sd)
    path.write_text("Time,Load Cell,Moving Forward\n" + "1.0,0.0,1.0\n" * 5000)
    with pytest.raises(InputError, match="Time"):
        read_bursts(campaign(tmp_path, load_cell=[path]))


def test_no_side_benches_are_no_error(tmp_path):
    empty = campaign(tmp_path)
    assert len(read_capacitance(empty).force) == 0 and read_spectra(empty) == ()
    assert len(read_bursts(empty).frequency) == 0


@pytest.mark.published
def test_published_benches(published):
    opened = open_campaign(published)
    readings = read_capacitance(opened)
    assert len(set(readings.trial)) == 10 and {2.0, 2.5, 3.0, 6.35} == set(np.round(readings.width * 1e3, 3))
    assert readings.capacitance[0] == pytest.approx(12.8e-12) and readings.force[0] == pytest.approx(0.0015)
    assert [len(spectrum.frequency) > 3 for spectrum in read_spectra(opened)] == [True] * 3
    bursts = read_bursts(opened)
    assert len(bursts.frequency) == 40 and 640 < np.median(bursts.frequency) < 656
