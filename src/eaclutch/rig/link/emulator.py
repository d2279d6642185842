"""A rig on a pseudo-terminal that behaves as the firmware does, fed with logs, whoever made them."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import select
import threading
import time
import tty
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import TracebackType

import numpy as np

from eaclutch.files import write_json
from eaclutch.records import Recording
from eaclutch.rig.link.faults import CORRUPTIONS, corrupt
from eaclutch.rig.link.protocol import BenchSetting, Columns, Command, Timing, digest, on_the_grid, render

_WRITE = 4096  # bytes a pseudo-terminal takes at once


Source = Callable[[BenchSetting, Command], Recording]


@dataclass(frozen=True)
class Sent:
    """One transfer as the emulated rig knows it: ``sha256`` of the undisturbed reply, and the fault."""

    setting: BenchSetting
    command: Command
    samples: int
    sha256: str
    fault: str | None


def setting_file(port: str | os.PathLike[str]) -> Path:
    """Where the knobs of the emulated rig stand: hidden beside its port, under the port's first name."""
    path = Path(port)
    return path.with_name(f".{path.name}.setting.json")


def turn_knobs(port: str | os.PathLike[str], setting: BenchSetting) -> None:
    """Set the emulated bench, as an operator would the real one."""
    write_json(setting_file(port), setting)


class EmulatedRig:
    """The emulated rig; use as a context manager. Its port is the symbolic link ``link`` (``<link>-1``, ...
    after it was unplugged and came back). ``ended`` is set when it is switched off or ``failure`` says why it failed.

    ``source`` gives the recording of a run; ``faults()`` the fault of the next transfer or None;
    ``bytes_per_s`` limits the link; ``journal`` gets a JSON line a transfer.
    """

    def __init__(
        self,
        source: Source,
        link: Path,
        *,
        rng: np.random.Generator,
        timing: Timing | None = None,
        speed_factor: float = 1.0,
        faults: Callable[[], str | None] = lambda: None,
        bytes_per_s: float | None = None,
        away: float = 0.3,
        journal: Path | None = None,
    ):
        self.source, self.link, self.rng, self.faults = source, Path(link), rng, faults
        self.timing = Timing() if timing is None else timing
        self.speed_factor, self.bytes_per_s, self.away, self.journal = (
            speed_factor,
            bytes_per_s,
            away,
            journal,
        )
        self.sent: list[Sent] = []
        self.setting: BenchSetting | None = None
        self.failure: BaseException | None = None
        self.ended = threading.Event()
        self._plugs = 0
        self._master = self._slave = -1
        self._thread = threading.Thread(target=self._serve, name="emulated rig", daemon=True)

    @property
    def port(self) -> Path:
        """The symbolic link to the pseudo-terminal under its present name."""
        return self.link if self._plugs <= 1 else self.link.with_name(f"{self.link.name}-{self._plugs - 1}")

    def __enter__(self) -> EmulatedRig:
        self._plug()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.ended.set()
        self._thread.join()
        self._unplug()
        setting_file(self.link).unlink(missing_ok=True)
        if self.failure is not None and kind is None:
            raise self.failure

    def _serve(self) -> None:
        try:
            pending = b""
            while not self.ended.is_set():
                if select.select([self._master], [], [], 0.05)[0]:
                    pending += os.read(self._master, 1024)
                while len(pending) >= 2 and not self.ended.is_set():
                    two, pending = pending[:2], pending[2:]
                    if 0 not in two:
                        self._run(Command.decode(two))
        except BaseException as error:  # shown when the rig is switched off
            self.failure = error
            self.ended.set()

    def _run(self, command: Command) -> None:
        came = time.monotonic()
        setting = self._read_setting()
        fault = self.faults()
        columns = self._columns(self.source(setting, command))
        if fault == "value_equals_count":
            columns = _with_count_among_data(columns)
        reply = render(columns)
        self._note(Sent(setting, command, len(columns), digest(columns), fault))
        motion = command.silence(self.timing) / self.speed_factor
        silence = max(0.0, motion - (time.monotonic() - came))
        if fault == "silence":
            return
        if fault == "unplug_in_motion":
            self._sleep(0.5 * silence)
            self._replug()
            return
        self._sleep(0.3 * silence if fault == "early_reply" else silence)
        if fault == "unplug":
            self._send(reply[: int(self.rng.integers(1, len(reply)))])
            self._replug()
            return
        self._send(corrupt(reply, fault, self.rng) if fault in CORRUPTIONS else reply, fault == "slow_host")

    def _columns(self, recording: Recording) -> Columns:
        keep = np.isfinite(recording.time) & np.isfinite(recording.force) & np.isfinite(recording.voltage)
        parts = (recording.time * 1e6, recording.force, recording.flag, recording.voltage)
        return on_the_grid(Columns(*(part[keep] for part in parts)))

    def _read_setting(self) -> BenchSetting:
        file = setting_file(self.link)
        if file.exists():
            return BenchSetting(**json.loads(file.read_text(encoding="utf-8")))
        return self.setting or BenchSetting(300.0, 1000.0, 2e-3, "brass")

    def _note(self, sent: Sent) -> None:
        self.sent.append(sent)
        if self.journal is not None:
            with self.journal.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(asdict(sent)) + "\n")

    def _send(self, reply: bytes, drop: bool = False) -> None:
        """Write as the firmware does; with ``drop``, what the host does not take at once is lost."""
        view, start, written = memoryview(reply), time.monotonic(), 0
        while view and not self.ended.is_set():
            if not select.select([], [self._master], [], 0.0 if drop else 0.05)[1]:
                if drop:
                    view = view[_WRITE // 4 :]
                    time.sleep(1e-4)
                continue
            with contextlib.suppress(BlockingIOError):
                done = os.write(self._master, view[:_WRITE])
                view, written = view[done:], written + done
            if self.bytes_per_s is not None:
                ahead = written / self.bytes_per_s - (time.monotonic() - start)
                if ahead > 0.002:
                    self._sleep(ahead)

    def _sleep(self, seconds: float) -> None:
        self.ended.wait(seconds)

    def _replug(self) -> None:
        self._unplug()
        self._sleep(self.away)
        self._plug()

    def _plug(self) -> None:
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._plugs += 1
        self.port.parent.mkdir(parents=True, exist_ok=True)
        self.port.unlink(missing_ok=True)
        self.port.symlink_to(os.ttyname(self._slave))

    def _unplug(self) -> None:
        self.port.unlink(missing_ok=True)
        for handle in (self._slave, self._master):
            with contextlib.suppress(OSError):
                os.close(handle)


def _with_count_among_data(columns: Columns) -> Columns:
    """The clock shifted by under one period so that one of its stamps equals the number of samples."""
    count = len(columns)
    row = int(np.searchsorted(columns.time_us, count))
    row = min(max(row, 1), count - 1)
    shifted = columns.time_us + (count - columns.time_us[row])
    if shifted[0] < 0:
        shifted = columns.time_us
    return replace(columns, time_us=shifted)
