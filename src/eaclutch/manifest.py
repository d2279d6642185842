"""Checksums that tie results to inputs: what was captured, what came out, whether both still stand."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from eaclutch.files import read_json, sha256, write_json, write_text
from eaclutch.provenance import commit, versions
from eaclutch.records import Campaign, InputError

# What the default run leaves: files at the top of the results folder, and these folders. Studies keep their own.
_FOLDERS = ("observables", "posterior", "predict", "diagnosis")
_NOT_RESULTS = ("manifest.json",)
# Attributes of a .nc file that equal draws do not share: when it was made, and references within the file.
_APART = {"created_at", "_NCProperties", "REFERENCE_LIST", "DIMENSION_LIST"}


def write_capture(campaign: Campaign, batch_size: int, output: Path) -> None:
    """Write capture.json: every file of the campaign with size and SHA-256, every run with its batch.

    A run's batch follows from its name alone, so that a new run changes one batch and not all. Where the campaign
    lay is noted beside it, in a file that is no result.
    """
    count = max(1, -(-len(campaign.logs) // batch_size))
    named = sorted((log.settings.run, log.path) for log in campaign.logs)
    runs = [
        {"run": run, "path": path.relative_to(campaign.folder).as_posix(), "batch": _batch(run, count)}
        for run, path in named
    ]
    paths = [campaign.folder / "campaign.yaml", *(path for _, path in named)]
    paths += [*campaign.capacitance_files, *campaign.permittivity_files, *campaign.load_cell_files]
    write_json(
        output,
        {
            "schema": 1,
            "campaign": campaign.bench.name,
            "batches": sorted({entry["batch"] for entry in runs}),
            "files": [_entry(path, campaign.folder) for path in paths],
            "runs": runs,
        },
    )
    write_text(output.parent / ".campaign", f"{campaign.folder.resolve()}\n")


def batch_runs(capture: Mapping[str, Any], batch: int) -> dict[str, str]:
    """The runs of one batch and their paths below the campaign's folder."""
    return {entry["run"]: entry["path"] for entry in capture["runs"] if entry["batch"] == batch}


def refuse_other_campaign(folder: str | Path, results: str | Path) -> None:
    """Raise InputError where ``results`` hold those of another campaign of the same name."""
    folder, results = Path(folder), Path(results)
    try:
        before = (results / ".campaign").read_text(encoding="utf-8").strip()
        capture = read_json(results / "capture.json")
    except OSError:
        return
    if Path(before) == folder.resolve():
        return
    logs = {entry["path"] for entry in capture["runs"]}
    for entry in capture["files"]:
        path = folder / entry["path"]
        if entry["path"] in logs and not (path.is_file() and sha256(path) == entry["sha256"]):
            raise InputError(
                f"{folder / 'campaign.yaml'}, name",
                f"{results} holds the results of another campaign of this name ({before})",
                "give one of them another name, or remove those results",
            )


def write_manifest(results: Path, config: Mapping[str, Any], output: Path) -> None:
    """Write manifest.json: inputs and results with SHA-256, config, seed, versions, commit."""
    capture = read_json(results / "capture.json")
    stated = {**config, "campaign": Path(config["campaign"]).name}
    write_json(
        output,
        {
            "schema": 1,
            "campaign": capture["campaign"],
            "inputs": capture["files"],
            "config": stated,
            "seed": config["seed"],
            "versions": versions(),
            "commit": commit(),
            "results": [_entry(path, results) for path in _result_files(results)],
        },
    )


def verify(results: Path, campaign: Path | None = None) -> list[str]:
    """What differs from manifest.json: changed, missing or unlisted results, and inputs where they can be read.

    ``campaign``: where the inputs lie; by default where they lay. An empty list: all stands.
    Raises InputError where there is no manifest.
    """
    try:
        manifest = read_json(results / "manifest.json")
    except (OSError, ValueError):
        raise InputError(
            results / "manifest.json", "is no manifest", "run the campaign to its end first"
        ) from None
    found = _differences(manifest["results"], results, "result")
    listed = {entry["path"] for entry in manifest["results"]}
    found += [
        f"result {path.relative_to(results)} is not in the manifest"
        for path in _result_files(results)
        if str(path.relative_to(results)) not in listed
    ]
    if campaign is None and (results / ".campaign").is_file():
        campaign = Path((results / ".campaign").read_text(encoding="utf-8").strip())
    if campaign is None or not campaign.is_dir():
        return [*found, f"the campaign's folder {campaign} cannot be read"]
    return found + _differences(manifest["inputs"], campaign, "input")


def _differences(entries: list[dict[str, Any]], folder: Path, kind: str) -> list[str]:
    found = []
    for entry in entries:
        path = folder / entry["path"]
        if not path.is_file():
            found.append(f"{kind} {entry['path']} is missing")
        elif content_hash(path) != entry["sha256"]:
            found.append(f"{kind} {entry['path']} has changed")
    return found


def _result_files(results: Path) -> list[Path]:
    paths = [path for path in results.glob("[!.]*") if path.is_file() and path.name not in _NOT_RESULTS]
    for folder in _FOLDERS:
        paths += [path for path in (results / folder).rglob("[!.]*") if path.is_file()]
    return sorted(paths)


def content_hash(path: Path) -> str:
    """SHA-256 of what a file says: of its bytes, or of the groups, arrays and attributes of a .nc file."""
    if path.suffix != ".nc":
        return sha256(path)
    digest = hashlib.sha256()

    def add(name: str, item: h5py.Group | h5py.Dataset) -> None:
        digest.update(name.encode())
        for key in sorted(set(item.attrs) - _APART):
            digest.update(key.encode() + _bytes(item.attrs[key]))
        if isinstance(item, h5py.Dataset):
            digest.update(_bytes(item[()]))

    with h5py.File(path) as file:
        add("", file)
        file.visititems(add)
    return digest.hexdigest()


def _bytes(value: object) -> bytes:
    """A number, text or array as bytes; texts by their characters, not by where they lie in memory."""
    array = np.asarray(value)
    return (
        repr(array.tolist()).encode() if array.dtype.kind in "OSU" else np.ascontiguousarray(array).tobytes()
    )


def _entry(path: Path, folder: Path) -> dict[str, Any]:
    return {
        "path": path.relative_to(folder).as_posix(),
        "bytes": path.stat().st_size,
        "sha256": content_hash(path),
    }


def _batch(run: str, batches: int) -> int:
    return int.from_bytes(hashlib.sha256(run.encode()).digest()[:8], "big") % batches
