"""Logs that carry code, burst when they are unpacked, or hold what is no number."""

from __future__ import annotations

import functools
import gzip
import lzma
import os
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hostile_campaigns import sound
from hostile_campaigns.sound import HEADER, NAME, base, case, sound_log


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


def _bomb(folder: Path, extension: str, opener: Callable) -> None:
    base(folder, log=False)
    chunk = b"1.0,0.0,0.0,0.0\n" * 65536
    with opener(folder / "tensile" / f"{NAME}.csv.{extension}", "wb") as stream:
        stream.write(HEADER.encode())
        for _ in range(sound.BOMB_MEGABYTES):
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
