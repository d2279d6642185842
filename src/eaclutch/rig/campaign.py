"""A campaign folder: what lies in it, checked before anything is parsed (contract: A campaign)."""

from __future__ import annotations

from pathlib import Path

from eaclutch.config import load_bench
from eaclutch.records import Campaign, InputError, LogFile
from eaclutch.rig.log_names import EXTENSIONS, parse_log_name


def open_campaign(folder: Path | str) -> Campaign:
    """List a campaign: bench, logs in the order of their names, further files; nothing else is parsed.

    Raises InputError for a folder that is none, no log at all, a name that is no log's, a run under two
    extensions, or a link that leads out of the campaign.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(folder, "is not a folder", "point `campaign` to a folder with tensile/*.csv")
    logs: dict[str, LogFile] = {}
    for path in _files(folder, "tensile", EXTENSIONS):
        settings = parse_log_name(path.name)
        if settings.run in logs:
            other = logs[settings.run].path.name
            raise InputError(path, f"the run is also there as {other}", "keep one of the two")
        logs[settings.run] = LogFile(settings, path)
    if not logs:
        raise InputError(
            folder / "tensile", "holds no log", f"put at least one log ({', '.join(EXTENSIONS)}) there"
        )
    csv = (".csv", ".csv.gz", ".csv.xz")
    return Campaign(
        folder=folder,
        bench=load_bench(folder),
        logs=tuple(logs[run] for run in sorted(logs)),
        capacitance_files=_files(folder, "capacitance", (*csv, ".xlsx")),
        permittivity_files=_files(folder, "permittivity", csv),
        load_cell_files=_files(folder, "load_cell", csv),
    )


def _files(folder: Path, kind: str, extensions: tuple[str, ...]) -> tuple[Path, ...]:
    """Files of one kind, by name; hidden files and Office's lock files are none."""
    place = folder / kind
    if not place.is_dir():
        return ()
    root = folder.resolve()
    found = []
    for path in sorted(place.iterdir()):
        if path.name.startswith((".", "~$")) or not path.name.endswith(extensions):
            continue
        if not path.is_file():
            continue
        if not path.resolve().is_relative_to(root):
            raise InputError(path, "is a link that leads out of the campaign", "copy the file itself")
        found.append(path)
    return tuple(found)
