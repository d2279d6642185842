"""Faults of the link to order: what can happen to a reply on its way to the host.

``CORRUPTIONS`` change the bytes; ``BEHAVIOURS`` change what the emulated rig does. ``value_equals_count`` is no
fault but the case that readers get wrong: the data are changed before they are sent, and must arrive.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

PACKET = 64  # bytes that USB loses together


def _lost_bytes(reply: bytes, rng: np.random.Generator) -> bytes:
    data = bytearray(reply)
    for where in sorted(rng.integers(0, len(data), rng.integers(1, 4)).tolist(), reverse=True):
        del data[where]
    return bytes(data)


def _lost_packets(reply: bytes, rng: np.random.Generator) -> bytes:
    data = bytearray(reply)
    for _ in range(rng.integers(1, 4)):
        where = int(rng.integers(0, max(1, len(data) // PACKET))) * PACKET
        del data[where : where + PACKET]
    return bytes(data)


def _lost_line(reply: bytes, rng: np.random.Generator) -> bytes:
    lines = reply.split(b"\r\n")
    del lines[int(rng.integers(0, len(lines) - 1))]
    return b"\r\n".join(lines)


def _line_ends(reply: bytes, rng: np.random.Generator, what: bytes, by: bytes) -> bytes:
    ends = reply.count(b"\r\n")
    which = int(rng.integers(0, ends))
    where = -1
    for _ in range(which + 1):
        where = reply.index(b"\r\n", where + 1)
    return reply[:where] + reply[where : where + 2].replace(what, by) + reply[where + 2 :]


def _merged_lines(reply: bytes, rng: np.random.Generator) -> bytes:
    return _line_ends(reply, rng, b"\r\n", b"")


def _lost_line_ending(reply: bytes, rng: np.random.Generator) -> bytes:
    return _line_ends(reply, rng, b"\r" if rng.random() < 0.5 else b"\n", b"")


def _lost_character(reply: bytes, rng: np.random.Generator) -> bytes:
    """One character that is not a line's end: a sign, a digit, a point."""
    where = int(rng.integers(0, len(reply)))
    while reply[where] in b"\r\n":
        where = int(rng.integers(0, len(reply)))
    return reply[:where] + reply[where + 1 :]


def _lost_sign(reply: bytes, rng: np.random.Generator) -> bytes:
    """The loss that no format shows; without a negative number any character is taken."""
    signs = [i for i in rng.integers(0, len(reply), 4000).tolist() if reply[i : i + 1] == b"-"]
    if not signs:
        where = reply.find(b"-")
        if where < 0:
            return _lost_character(reply, rng)
        signs = [where]
    return reply[: signs[0]] + reply[signs[0] + 1 :]


def _garbage(reply: bytes, rng: np.random.Generator) -> bytes:
    where = int(rng.integers(0, len(reply)))
    noise = rng.integers(0, 256, rng.integers(4, 64), dtype=np.uint8).tobytes()
    overwrite = len(noise) if rng.random() < 0.5 else 0
    return reply[:where] + noise + reply[where + overwrite :]


def _chatter_first(reply: bytes, rng: np.random.Generator) -> bytes:
    return b"Teensy ready\r\n" + reply


def _cut_short(reply: bytes, rng: np.random.Generator) -> bytes:
    return reply[: int(rng.integers(1, len(reply)))]


def _swapped_digit(reply: bytes, rng: np.random.Generator) -> bytes:
    """A decimal of a force or voltage becomes another one."""
    while True:
        where = int(rng.integers(len(reply) // 4, len(reply)))
        line = reply[reply.rfind(b"\n", 0, where) + 1 : reply.find(b"\r", where)]
        if reply[where : where + 1].isdigit() and b"." in line:
            other = (reply[where] - 48 + int(rng.integers(1, 10))) % 10 + 48
            return reply[:where] + bytes([other]) + reply[where + 1 :]


CORRUPTIONS: dict[str, Callable[[bytes, np.random.Generator], bytes]] = {
    "lost_bytes": _lost_bytes,
    "lost_packets": _lost_packets,
    "lost_line": _lost_line,
    "lost_line_ending": _lost_line_ending,
    "lost_character": _lost_character,
    "lost_sign": _lost_sign,
    "merged_lines": _merged_lines,
    "garbage": _garbage,
    "chatter_first": _chatter_first,
    "cut_short": _cut_short,
    "swapped_digit": _swapped_digit,
}
BEHAVIOURS = ("silence", "unplug", "unplug_in_motion", "slow_host", "early_reply", "value_equals_count")
FAULTS = (*CORRUPTIONS, *BEHAVIOURS)


def corrupt(reply: bytes, fault: str, rng: np.random.Generator) -> bytes:
    """``reply`` after the named corruption."""
    return CORRUPTIONS[fault](reply, rng)


def random_faults(
    share: float, rng: np.random.Generator, kinds: Sequence[str] = FAULTS
) -> Callable[[], str | None]:
    """A fault for each transfer in turn: one of ``kinds`` with probability ``share``, else None."""

    def draw() -> str | None:
        return str(rng.choice(list(kinds))) if rng.random() < share else None

    return draw
