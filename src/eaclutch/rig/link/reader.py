"""One transfer over a serial port: the command goes out, the reply comes in whole, or a fault has a name."""

from __future__ import annotations

import errno
import termios
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType

import serial

from eaclutch.records import InputError
from eaclutch.rig.link.ports import usb_identity, wait_for_port
from eaclutch.rig.link.protocol import BAUD, MEMORY_SAMPLES, Command, Timing
from eaclutch.rig.link.transfer import TransferFault, announced_lines

# what a port that is pulled raises, by which call notices first
_GONE = (serial.SerialException, OSError, termios.error)
LONGEST_LINE = 16  # bytes on average; a reply beyond 4 x 250 000 of these is no reply
Progress = Callable[[str, float], None]  # phase, share done


@dataclass(frozen=True)
class LinkSettings:
    """Time-outs [s] of each phase, and how much faster than the bench an emulated rig runs."""

    speed_factor: float = 1.0
    silence_margin: float = 5.0  # beyond the motion, until the first byte
    idle: float = 1.0  # between two bytes of a reply
    reappear: float = 20.0  # for a port that vanished
    early_share: float = 0.9  # a reply before this part of the motion answers another command


@dataclass(frozen=True)
class Reply:
    """What came: the bytes, the port they came from, and when [s after the command]."""

    raw: bytes
    port: str
    first_byte: float
    last_byte: float


class SerialLink:
    """A port that nobody else may hold. ``transfer`` raises TransferFault; the caller decides to repeat.

    ``port`` as in ``find_port``. Opening raises InputError where the port is missing or held by another.
    """

    def __init__(self, port: str | None, timing: Timing, settings: LinkSettings | None = None):
        self.wanted, self.timing = port, timing
        self.settings = LinkSettings() if settings is None else settings
        self._serial: serial.Serial | None = None
        self.port = ""
        self._identity: str | None = None

    def __enter__(self) -> SerialLink:
        self._open(0.0)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the port."""
        if self._serial is not None:
            self._serial.close()
            self._serial = None

    def transfer(self, command: Command, progress: Progress = lambda phase, share: None) -> Reply:
        """Send the command and read the reply until all announced lines are there.

        Raises TransferFault: ``vanished``, ``silence``, ``early_reply``, ``stalled``, ``no_count``, ``too_long``;
        InputError where the port does not come back.
        """
        two = command.encode()
        if self._serial is None:
            self._open(self.settings.reappear)
        assert self._serial is not None
        raw = bytearray()
        try:
            self._serial.reset_input_buffer()
            start = time.monotonic()
            self._serial.write(two)
            self._serial.flush()
            return self._read(command, raw, progress, start)
        except _GONE as error:
            self.close()
            raise _Partial("vanished", f"the port went away after {len(raw)} bytes ({error})", raw) from None

    def settle(self, command: Command) -> int:
        """Wait until the rig has nothing more to say: it may still run, and hold a second command.

        Returns the bytes that were thrown away. Raises InputError where a port that vanished stays away.
        """
        if self._serial is None:
            self._open(self.settings.reappear)
        silence = command.silence(self.timing) / self.settings.speed_factor
        return self._drain(silence + self.settings.silence_margin)

    def quiet(self) -> int:
        """Throw away what still comes of a reply, until the line is idle. Returns the bytes thrown away."""
        return self._drain(self.settings.idle)

    def _drain(self, seconds: float) -> int:
        thrown, last = 0, time.monotonic()
        try:
            while self._serial is not None and time.monotonic() - last < seconds:
                got = len(self._chunk())
                if got:
                    thrown, last = thrown + got, time.monotonic()
        except _GONE:
            self.close()
        return thrown

    def _read(self, command: Command, raw: bytearray, progress: Progress, start: float) -> Reply:
        motion = command.silence(self.timing) / self.settings.speed_factor
        longest = 4 * MEMORY_SAMPLES * LONGEST_LINE
        lines, wanted, first, last = 0, None, 0.0, 0.0
        while wanted is None or lines < wanted:
            chunk = self._chunk()
            now = time.monotonic() - start
            if chunk:
                if not raw:
                    first = now
                    if now < self.settings.early_share * motion:
                        what = f"it came {now:.3f} s after the command, the rig moves for {motion:.3f} s"
                        raise _Partial("early_reply", what, chunk)
                raw += chunk
                last = now
                lines += chunk.count(b"\n")
                if wanted is None:
                    wanted = _announced(raw)
                if len(raw) > longest:
                    raise _Partial("too_long", f"more than {longest} bytes", raw)
                progress("transfer", lines / wanted if wanted else 0.0)
            elif not raw:
                progress("motion", min(1.0, now / motion))
                if now > motion + self.settings.silence_margin:
                    raise _Partial("silence", f"not a byte {now:.1f} s after the command", raw)
            elif now - last > self.settings.idle:
                break  # the parser says what is missing, or mends a lost line ending
        return Reply(bytes(raw), self.port, first, last)

    def _chunk(self) -> bytes:
        assert self._serial is not None
        return self._serial.read(max(1, self._serial.in_waiting))

    def _open(self, wait: float) -> None:
        end = time.monotonic() + wait
        path = wait_for_port(self.wanted, wait, self._identity)
        while True:
            try:
                self._serial = serial.Serial(path, BAUD, timeout=0.02, write_timeout=5.0, exclusive=True)
                self.port = path
                self._identity = self._identity or usb_identity(path)
                return
            except _GONE as error:
                # right after plugging in, the device is there before its permissions are
                if time.monotonic() < end:
                    time.sleep(0.1)
                    path = wait_for_port(self.wanted, max(0.0, end - time.monotonic()), self._identity)
                    continue
                raise InputError(f"port {path}", *_reason(error)) from None


class _Partial(TransferFault):
    """A fault with the bytes that came, to be kept aside."""

    def __init__(self, code: str, detail: str, raw: bytes | bytearray):
        super().__init__(code, detail)
        self.raw = bytes(raw)


def partial_bytes(fault: TransferFault) -> bytes:
    """The bytes that a faulty transfer did bring."""
    return fault.raw if isinstance(fault, _Partial) else b""


def _announced(raw: bytearray) -> int | None:
    try:
        return announced_lines(raw)
    except TransferFault as fault:
        raise _Partial(fault.code, fault.detail, raw) from None


def _reason(error: Exception) -> tuple[str, str]:
    number = getattr(error, "errno", None)
    if number in (errno.EAGAIN, errno.EBUSY, errno.EWOULDBLOCK) or "lock" in str(error).lower():
        return "another program holds it", "end the other capture (or terminal) first"
    if number == errno.EACCES:
        return "no permission", "add yourself to the group that owns the port (often dialout)"
    return f"cannot be opened ({error})", "check the cable and the port's name"
