"""Finding the rig's port, also after it went away and came back under another name."""

from __future__ import annotations

import glob
import re
import stat
import time
from pathlib import Path

from serial.tools import list_ports

from eaclutch.records import InputError

TEENSY_VENDOR = 0x16C0
_USB = re.compile(r"usb:(?P<vendor>[0-9A-Fa-f]{4}):(?P<product>[0-9A-Fa-f]{4})(?::(?P<serial>[\w.-]+))?")


def find_port(port: str | None) -> str:
    """The device path that ``port`` stands for.

    ``port``: a path, a pattern (``/dev/ttyACM*``), ``usb:<vendor>:<product>[:<serial number>]``, or None for
    the one Teensy that is plugged in. Raises InputError where none or more than one is there.
    """
    found = _candidates(port)
    shown = port or "a Teensy"
    if not found:
        raise InputError("port", f"{shown} is not there", "plug the rig in, or name its port with --port")
    if len(found) > 1:
        raise InputError("port", f"{shown} is any of {', '.join(found)}", "name one with --port")
    return found[0]


def usb_identity(path: str) -> str | None:
    """``usb:...`` of the device at ``path``, by which it is known under any name; None where it has none."""
    for found in list_ports.comports():
        if found.device == path and found.vid is not None and found.pid is not None:
            serial = f":{found.serial_number}" if found.serial_number else ""
            return f"usb:{found.vid:04x}:{found.pid:04x}{serial}"
    return None


def wait_for_port(port: str | None, seconds: float, identity: str | None = None) -> str:
    """``find_port``, given ``seconds`` for the port to (re)appear; failing that, the device ``identity``."""
    end = time.monotonic() + seconds
    while True:
        try:
            return find_port(port)
        except InputError:
            if identity is not None and len(same := _candidates(identity)) == 1:
                return same[0]
            if time.monotonic() >= end:
                raise
            time.sleep(min(0.1, seconds))


def _candidates(port: str | None) -> list[str]:
    if port is None:
        return sorted(found.device for found in list_ports.comports() if found.vid == TEENSY_VENDOR)
    if usb := _USB.fullmatch(port):
        return sorted(
            found.device
            for found in list_ports.comports()
            if (found.vid, found.pid) == (int(usb["vendor"], 16), int(usb["product"], 16))
            and usb["serial"] in (None, found.serial_number)
        )
    # a pattern is the operator's own; a plain path is its own only match
    matches = sorted(glob.glob(port))  # noqa: PTH207 (absolute patterns are what it is for)
    return [path for path in matches if _is_terminal(path)]


def _is_terminal(path: str) -> bool:
    """Whether ``path`` leads to a character device: a name that is left over, or a file beside it, does not."""
    try:
        return stat.S_ISCHR(Path(path).stat().st_mode)
    except OSError:
        return False
