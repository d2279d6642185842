"""Permittivity spectra: a csv a source, frequency_hz and relative_permittivity (contract: A campaign)."""

from __future__ import annotations

import numpy as np

from eaclutch.records import Campaign, InputError, Spectrum
from eaclutch.rig.log_names import run_of
from eaclutch.rig.small_tables import numbers, read_rows

NAMES = ("frequency_hz", "relative_permittivity")


def read_spectra(campaign: Campaign) -> tuple[Spectrum, ...]:
    """One spectrum a file, by the file's name; points sorted by frequency.

    Raises InputError naming file and row for a value that is no frequency (> 0) or no permittivity (>= 1).
    """
    spectra = []
    for path in campaign.permittivity_files:
        rows = read_rows(path, NAMES, header=False)
        table = numbers(path, rows, (0, 1))
        if len(table) == 0:
            raise InputError(path, "holds no point", f"give rows of {', '.join(NAMES)}")
        wrong = (table[:, 0] <= 0) | (table[:, 1] < 1) | (table[:, 1] > 1e6)
        if wrong.any():
            i = int(np.argmax(wrong))
            what = f"{table[i, 0]:g} Hz, {table[i, 1]:g} is no point of a spectrum"
            raise InputError(
                f"{path}, row {rows[i][0]}", what, "give frequency > 0 and real permittivity >= 1"
            )
        table = table[np.argsort(table[:, 0], kind="stable")]
        spectra.append(Spectrum(run_of(path), table[:, 0], table[:, 1]))
    return tuple(spectra)
