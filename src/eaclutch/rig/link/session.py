"""A capture session: run after run of a plan until the campaign has them all, whatever the link does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Protocol

from eaclutch.records import InputError, Recording
from eaclutch.rig.link.plan import Plan, Slot
from eaclutch.rig.link.protocol import BenchSetting, Columns, Command, digest
from eaclutch.rig.link.reader import Reply, SerialLink, partial_bytes
from eaclutch.rig.link.setting_check import check_setting
from eaclutch.rig.link.store import CampaignStore, missing_slots
from eaclutch.rig.link.transfer import Transfer, TransferFault, parse_transfer
from eaclutch.rig.log_names import parse_log_name

# After these the rig may still move, or hold a second command, and would answer later.
_RIG_MAY_STILL_RUN = ("early_reply", "silence", "vanished", "no_count", "too_long")


class Operator(Protocol):
    """Whoever sets supply, frequency, substrate and weight."""

    def change(self, before: BenchSetting | None, after: BenchSetting) -> None:
        """Returns when the bench is as ``after`` says; ``before`` is None at the start of a session."""

    def wrong(self, setting: BenchSetting, fault: TransferFault) -> None:
        """The run showed that the bench is not as ``setting`` says. Returns when it is."""


class Observer(Protocol):
    """Whoever watches the session."""

    def started(self, slot: Slot, done: int, total: int) -> None:
        """A run begins; ``done`` of ``total`` missing runs are in the campaign."""

    def progress(self, phase: str, share: float) -> None:
        """``phase`` (motion, transfer) has got so far."""

    def refused(self, slot: Slot, fault: TransferFault, attempt: int) -> None:
        """A transfer was refused and kept aside."""

    def finished(self, recording: Recording, path: Path, repairs: tuple[str, ...]) -> None:
        """A run is in the campaign."""


@dataclass(frozen=True)
class Summary:
    """How a session went: runs that are now in the campaign, slots given up, transfers refused."""

    finished: tuple[Path, ...]
    failed: tuple[Slot, ...]
    refused: int


class Unattended:
    """Nobody is there: the bench stays as the first run of the session needs it."""

    def change(self, before: BenchSetting | None, after: BenchSetting) -> None:
        """Raises InputError where something would have to be changed."""
        if before is not None and before != after:
            what = f"the next run needs {describe(after)}, the bench is at {describe(before)}"
            raise InputError("capture", what, "capture with an operator (without --unattended)")

    def wrong(self, setting: BenchSetting, fault: TransferFault) -> None:
        """Raises InputError: nobody can mend it."""
        raise InputError("capture", fault.detail, "set the bench and capture again")


def describe(setting: BenchSetting) -> str:
    """A setting as an operator says it."""
    weight = "no weight" if setting.preload is None else f"{setting.preload / 9.80665e-3:g} g"
    drive = "DC" if setting.frequency <= 0.1 else f"{setting.frequency:g} Hz"
    return f"{setting.voltage:g} V, {drive}, {setting.substrate} {setting.width * 1e3:g} mm, {weight}"


def run_session(
    plan: Plan,
    store: CampaignStore,
    link: SerialLink,
    operator: Operator,
    observer: Observer,
    excluded: Mapping[str, str] | None = None,
) -> Summary:
    """Capture what the campaign lacks of the plan. May be stopped at any time and started again.

    A transfer that fails is repeated ``plan.retries`` times, then its slot is given up until the next session.
    Raises InputError where nothing more can be done (port gone, disk full, bench not as planned).
    """
    missing = missing_slots(plan, store.campaign, excluded)
    _let_the_rig_finish(store, link)
    finished: list[Path] = []
    failed: list[Slot] = []
    refused = 0
    now: BenchSetting | None = None
    for slot in missing:
        if now != slot.setting:
            operator.change(now, slot.setting)
            now = slot.setting
        observer.started(slot, len(finished), len(missing))
        for attempt in range(plan.retries + 1):
            started = datetime.now()
            name = store.free_name(slot, started)
            store.remember_command(asdict(slot.command))
            reply: Reply | None = None
            try:
                reply = link.transfer(slot.command, observer.progress)
                transfer = parse_transfer(reply.raw, plan.timing, plan.grid)
                sensed = check_setting(transfer.columns, slot.setting, plan.voltage_tolerance)
            except TransferFault as fault:
                refused += 1
                raw = partial_bytes(fault) if reply is None else reply.raw
                store.keep_aside(name, raw, fault, {"plan": plan.name, "started": started.isoformat()})
                observer.refused(slot, fault, attempt)
                if fault.code in _RIG_MAY_STILL_RUN:
                    link.settle(slot.command)
                elif fault.code.startswith("wrong_"):
                    operator.wrong(slot.setting, fault)
                else:
                    link.quiet()
                store.remember_command(None)
                continue
            recording = _recording(name, transfer)
            record = _record(plan, slot, started, reply, transfer, attempt) | {"sensed": sensed}
            path = store.add(recording, name, plan.log_format, record)
            store.remember_command(None)
            finished.append(path)
            observer.finished(recording, path, transfer.repairs)
            break
        else:
            failed.append(slot)
    return Summary(tuple(finished), tuple(failed), refused)


def _let_the_rig_finish(store: CampaignStore, link: SerialLink) -> None:
    """A rig that was told to run before a crash must not answer the next command with the last one's data."""
    pending = store.pending_command()
    if pending is not None:
        link.settle(Command(**pending))
        store.remember_command(None)


def _recording(name: str, transfer: Transfer) -> Recording:
    columns: Columns = transfer.columns
    settings = parse_log_name(name)
    return Recording(
        settings, columns.time_us * 1e-6, columns.force, columns.flag, columns.voltage, transfer.repairs
    )


def _record(
    plan: Plan, slot: Slot, started: datetime, reply: Reply, transfer: Transfer, attempt: int
) -> dict[str, object]:
    """What is kept beside each log: how the data came, and what was checked."""
    return {
        "schema": 1,
        "plan": plan.name,
        "repeat": slot.repeat,
        "setting": asdict(slot.setting),
        "command_bytes": slot.command.encode().hex(),
        "host_time": started.astimezone().isoformat(),
        "port": reply.port,
        "first_byte_s": reply.first_byte,
        "last_byte_s": reply.last_byte,
        "reply_bytes": len(reply.raw),
        "reply_sha256": digest(transfer.columns),
        "firmware_reply": reply.raw[:16].split(b"\n")[0].strip().decode("ascii"),
        "attempt": attempt,
        "repairs": list(transfer.repairs),
        "checks": transfer.checks,
        "software": version("eaclutch"),
    }
