"""Reading and writing logs: what is right is read right, what is wrong is one clear error or a flag."""

from __future__ import annotations

import gzip
import lzma
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eaclutch.records import InputError
from eaclutch.rig.log_names import log_name, parse_log_name
from eaclutch.rig.logs import EXTENSIONS, HEADER, read_log, write_log
from rig.made_run import Made, make_run


@pytest.fixture(scope="module")
def recording():
    return make_run(Made(after=0.6, travel=1e-4), np.random.default_rng(0))[0]


@pytest.fixture
def text(recording, tmp_path):
    path = write_log(recording, tmp_path / f"{recording.settings.run}.csv")
    return path, path.read_bytes()


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_what_is_written_is_read(recording, tmp_path, extension):
    path = write_log(recording, tmp_path / f"{recording.settings.run}{extension}")
    again = read_log(path)
    assert again.settings == recording.settings and again.flags == ()
    assert np.array_equal(again.time, recording.time)
    assert np.allclose(again.force, recording.force, rtol=0, atol=5.1e-9)
    assert np.array_equal(again.flag, recording.flag)
    assert np.allclose(again.voltage, recording.voltage, rtol=0, atol=5.1e-7)


def test_text_is_the_rigs(text):
    lines = text[1].decode().splitlines()
    assert lines[0] == "Time,Load Cell,Moving Forward,Relay Output"
    time, _, flag, _ = lines[1].split(",")
    assert time == "900.0" and flag == "0.0"


def test_columns_are_found_by_name(text, recording):
    path, raw = text
    rows = [line.split(",") for line in raw.decode().splitlines()]
    path.write_text("\n".join(";".join(row[i] for i in (3, 0, 2, 1)) for row in rows))
    again = read_log(path)
    assert np.allclose(again.force, recording.force, atol=1e-8)
    assert again.flags == ("columns_reordered",)


def test_nan_bad_cells_and_short_lines_are_flagged(text):
    path, raw = text
    lines = raw.decode().splitlines()
    cells = lines[500].split(",")
    lines[500] = ",".join([cells[0], "nan", *cells[2:]])
    lines[700] = lines[700].replace(".", "x", 2)
    lines[900] = lines[900][:9]
    path.write_text("\n".join(lines) + "\n")
    again = read_log(path)
    assert {"bad_cells", "bad_rows"} <= set(again.flags)
    assert np.isnan(again.force[499]) and len(again.time) == len(lines) - 2


def test_a_file_cut_short_keeps_its_whole_lines(text, recording, tmp_path):
    path, raw = text
    path.write_bytes(raw[: len(raw) * 2 // 3])
    cut = read_log(path)
    assert "cut_short" in cut.flags
    assert np.array_equal(cut.time, recording.time[: len(cut.time)])
    packed = tmp_path / f"{recording.settings.run}.csv.gz"
    packed.write_bytes(gzip.compress(raw)[:-2000])
    assert "cut_short" in read_log(packed).flags


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda raw: b"", "row 1"),
        (lambda raw: b"\x00\xff" * 4000, "row 1"),
        (lambda raw: raw.split(b"\n", 1)[1], "row 1"),
        (lambda raw: raw.split(b"\n", 1)[0] + b"\n", "0 rows"),
        (lambda raw: raw.replace(b"Load Cell", b"Kraft \xc3\xbc"), "row 1"),
        (lambda raw: raw.replace(b",", b"|"), "row 1"),
        (lambda raw: raw.replace(b".", b"x"), "row 2"),
        (lambda raw: b"\n".join(line[:-9] for line in raw.split(b"\n")), "row"),
    ],
)
def test_what_is_no_log_is_one_error_with_its_place(text, damage, says):
    path, raw = text
    path.write_bytes(damage(raw))
    with pytest.raises(InputError) as error:
        read_log(path)
    assert path.name in str(error.value) and says in str(error.value) and "\n" not in str(error.value)


def test_swapped_columns_are_refused(recording, tmp_path):
    table = np.stack([recording.time * 1e6, recording.voltage, recording.flag, recording.force], axis=1)
    path = tmp_path / f"{recording.settings.run}.npy"
    np.save(path, table)
    with pytest.raises(InputError, match="Load Cell"):
        read_log(path)
    np.save(path, table[:, [0, 2, 1, 3]])
    with pytest.raises(InputError, match="Moving Forward"):
        read_log(path)


@pytest.mark.parametrize(
    "array", [np.zeros((5, 3)), np.zeros(40), np.zeros((500, 4), np.float32), np.array([[{}] * 4] * 200)]
)
def test_other_arrays_are_refused(recording, tmp_path, array):
    path = tmp_path / f"{recording.settings.run}.npy"
    np.save(path, array, allow_pickle=True)
    with pytest.raises(InputError, match=r"float64 of shape \(n, 4\)"):
        read_log(path)


def test_bombs_and_endless_records_stop_early(recording, tmp_path):
    line = b"1.0,0.1,0.0,2.0\n"
    for opener, extension in ((gzip.compress, ".csv.gz"), (lzma.compress, ".csv.xz")):
        path = tmp_path / f"{recording.settings.run}{extension}"
        path.write_bytes(opener(",".join(HEADER).encode() + b"\n" + line * 4_000_000))
        with pytest.raises(InputError, match="more than"):
            read_log(path)
    path = tmp_path / f"{recording.settings.run}.npy"
    header = {"descr": "<f8", "fortran_order": False, "shape": (10_000_000, 4)}
    with path.open("wb") as stream:
        np.lib.format.write_array_header_1_0(stream, header)
    with pytest.raises(InputError, match="10000000 rows"):
        read_log(path)


@given(
    speed=st.integers(1, 200),
    volts=st.integers(0, 5000),
    hertz=st.sampled_from([0.1, 1, 10, 2000, 12345.5]),
    width=st.integers(1, 40),
    preload=st.none() | st.integers(0, 500),
)
@settings(max_examples=60, deadline=None)
def test_names_go_both_ways(recording, speed, volts, hertz, width, preload):
    wanted = replace(
        recording.settings, speed=speed * 5e-5, voltage=float(volts), frequency=hertz, width=width * 5e-4,
        preload=None if preload is None else preload * 9.80665e-3,
    )  # fmt: skip
    found = parse_log_name(log_name(wanted) + ".csv.xz")
    assert found.run == log_name(wanted) and found.preload == pytest.approx(wanted.preload)
    for field in ("speed", "voltage", "frequency", "width", "travel"):
        assert getattr(found, field) == pytest.approx(getattr(wanted, field), rel=1e-9)


@given(st.text(max_size=120))
@settings(max_examples=200, deadline=None)
def test_other_names_are_one_error(name):
    with pytest.raises(InputError) as error:
        parse_log_name(name)
    assert "\n" not in str(error.value)


@given(st.binary(max_size=3000), st.sampled_from(EXTENSIONS))
@settings(max_examples=150, deadline=None)
def test_random_bytes_are_one_error(tmp_path_factory, raw, extension):
    folder = tmp_path_factory.mktemp("bytes")
    path = folder / f"20240101_00_00_00_bts_dx=1.5_v=0.5_Fpre=-1g_V=300_f=1000_w=2_brass{extension}"
    path.write_bytes(raw)
    with pytest.raises(InputError):
        read_log(path)
