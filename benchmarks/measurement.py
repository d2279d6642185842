"""Recorded measurements: docs/measurements/<name>.json with the command, the date and the commit."""

from __future__ import annotations

import platform
import subprocess
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

from eaclutch.files import write_json

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "measurements"


def commit() -> str:
    """The commit that is measured."""
    return subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True,
                          cwd=FOLDER.parent).stdout.strip()  # fmt: skip


def record(name: str, command: str, values: Mapping[str, object]) -> None:
    """Write one measurement; ``values`` must be plain JSON."""
    head = {
        "command": command,
        "date": datetime.now(UTC).date().isoformat(),
        "commit": commit(),
        "cpu": platform.machine(),
    }
    FOLDER.mkdir(parents=True, exist_ok=True)
    write_json(FOLDER / f"{name}.json", head | dict(values))
