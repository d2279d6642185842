"""Runs enter a campaign whole or not at all, and never replace one that is there.

Everything is prepared in a folder beside the campaign (``<campaign>.capture``, the same file system): the log,
then its record. The record's appearance there is what makes the run finished; what a crash leaves after it is
carried on with at the next start, what it leaves before is kept aside.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from datetime import datetime, timedelta
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from eaclutch.files import hold, read_json, sha256, write_json
from eaclutch.records import InputError, Recording
from eaclutch.rig.link.plan import Plan, Slot, condition_key
from eaclutch.rig.link.protocol import Columns, digest
from eaclutch.rig.link.transfer import TransferFault
from eaclutch.rig.log_names import EXTENSIONS, log_name, parse_log_name, run_of
from eaclutch.rig.logs import read_log, write_log

_LARGEST_RECORD = 100_000  # bytes


def captured_runs(campaign: Path) -> dict[str, str | None]:
    """Runs of a campaign and the plan that each was captured for (None: from elsewhere)."""
    runs: dict[str, str | None] = {}
    for path in sorted((campaign / "tensile").glob("[!.]*")):
        if path.name.endswith(EXTENSIONS):
            record = campaign / "capture" / f"{run_of(path)}.json"
            runs[run_of(path)] = _plan_of(record) if record.is_file() else None
    return runs


def _plan_of(record: Path) -> str | None:
    """The plan that a run's record names; records come with a campaign, so they may hold anything."""
    try:
        if record.stat().st_size > _LARGEST_RECORD or record.is_symlink():
            return None
        content = read_json(record)
    except (OSError, ValueError, RecursionError):
        return None
    plan = content.get("plan") if isinstance(content, dict) else None
    return plan if isinstance(plan, str) else None


def missing_slots(plan: Plan, campaign: Path, excluded: Mapping[str, str] | None = None) -> list[Slot]:
    """What the campaign lacks of the plan, in the plan's order; runs that are ``excluded`` do not count."""
    have: dict[str, int] = {}
    for run, captured_for in captured_runs(campaign).items():
        if run not in (excluded or {}) and (plan.count_existing or captured_for == plan.name):
            key = condition_key(parse_log_name(run))
            have[key] = have.get(key, 0) + 1
    missing = []
    for slot in plan.slots:
        key = condition_key(slot.settings(datetime(2000, 1, 1)))
        if have.get(key, 0) > 0:
            have[key] -= 1
        else:
            missing.append(slot)
    return missing


class CampaignStore:
    """A campaign that one capture at a time adds to; use as a context manager."""

    def __init__(self, campaign: Path):
        self.campaign = Path(campaign)
        self.aside = self.campaign.with_name(f"{self.campaign.name}.capture")
        self._staging = self.aside / "staging"
        self._lock: int | None = None

    def __enter__(self) -> CampaignStore:
        if not (self.campaign / "campaign.yaml").is_file():
            remedy = "make the campaign's folder with a campaign.yaml first"
            raise InputError(self.campaign / "campaign.yaml", "there is no such file", remedy)
        self._staging.mkdir(parents=True, exist_ok=True)
        try:
            self._lock = hold(self.aside / "lock")
        except BlockingIOError:
            raise InputError(self.campaign, "another capture adds to it", "end that one first") from None
        self._recover()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._lock is not None:
            os.close(self._lock)

    def free_name(self, slot: Slot, now: datetime) -> str:
        """The log's name at the next second that no run has; names have whole seconds, runs may not."""
        taken = {path.name[:17] for path in (self.campaign / "tensile").glob("*")}
        while now.strftime("%Y%m%d_%H_%M_%S") in taken:
            now += timedelta(seconds=1)
        return log_name(slot.settings(now))

    def add(self, recording: Recording, name: str, log_format: str, record: Mapping[str, Any]) -> Path:
        """Put a verified run into the campaign; returns its path.

        Raises InputError where a run of that name is there, or what was written does not read back the same.
        """
        log = self._staging / f"{name}{log_format}"
        write_log(recording, log)
        if digest(columns_of(read_log(log))) != digest(columns_of(recording)):
            raise InputError(log, "does not read back as it was sent", "check the disk")
        full = {
            **record,
            "run": name,
            "log": log.name,
            "bytes": log.stat().st_size,
            "log_sha256": sha256(log),
        }
        write_json(self._staging / f"{name}.json", full)
        sync_folder(self._staging)
        return self._publish(name)

    def keep_aside(self, name: str, raw: bytes, fault: TransferFault, record: Mapping[str, Any]) -> None:
        """Keep what a refused transfer brought, and why it was refused, outside the campaign."""
        place = self.aside / "refused"
        place.mkdir(exist_ok=True)
        number = sum(1 for _ in place.glob("*.json"))
        (place / f"{number:05d}_{name}.bytes").write_bytes(raw)
        write_json(
            place / f"{number:05d}_{name}.json", {**record, "fault": fault.code, "detail": fault.detail}
        )

    def remember_command(self, record: Mapping[str, Any] | None) -> None:
        """Note that the rig was told to run (None: it has answered), for whoever starts after a crash."""
        path = self.aside / "command.json"
        if record is None:
            path.unlink(missing_ok=True)
        else:
            write_json(path, record)

    def pending_command(self) -> Mapping[str, Any] | None:
        """What the rig was told when the last capture ended without its answer."""
        path = self.aside / "command.json"
        return read_json(path) if path.is_file() else None

    def _publish(self, name: str) -> Path:
        """Record first, log last, so that every log of the campaign has its record; both by rename."""
        record = self._staging / f"{name}.json"
        log = self._staging / json.loads(record.read_text(encoding="utf-8"))["log"]
        for folder in ("tensile", "capture"):
            (self.campaign / folder).mkdir(exist_ok=True)
        target = self.campaign / "tensile" / log.name
        if log.exists():
            if any((self.campaign / "tensile" / f"{name}{extension}").exists() for extension in EXTENSIONS):
                raise InputError(
                    target, "the run is there already", f"an existing run is never replaced: move {log}"
                )
            copy = self._staging / f".{record.name}"
            copy.write_bytes(record.read_bytes())
            with copy.open("rb") as stream:
                os.fsync(stream.fileno())
            copy.rename(self.campaign / "capture" / record.name)
            sync_folder(self.campaign / "capture")
            log.rename(target)
            sync_folder(target.parent)
        record.unlink()
        return target

    def _recover(self) -> None:
        """Finish what a crash interrupted after the run was complete; keep aside what it interrupted before."""
        for record in sorted(self._staging.glob("[!.]*.json")):
            log = self._staging / read_json(record)["log"]
            if log.exists() and sha256(log) != read_json(record)["log_sha256"]:
                continue
            self._publish(record.stem)
        left = self.aside / "unfinished"
        for path in sorted(self._staging.iterdir()):
            left.mkdir(exist_ok=True)
            path.rename(left / path.name.lstrip("."))


def columns_of(recording: Recording) -> Columns:
    """A recording's columns as the rig sends them."""
    return Columns(np.rint(recording.time * 1e6), recording.force, recording.flag, recording.voltage)


def sync_folder(folder: Path) -> None:
    """Make the names in a folder last through a power cut."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
