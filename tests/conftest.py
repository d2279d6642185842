"""Fixtures shared by all rooms' tests."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def published() -> Path:
    """The folder of published recordings, or a skip with its reason."""
    default = Path(__file__).resolve().parents[2] / "shared" / "published"
    folder = Path(os.environ.get("EACLUTCH_PUBLISHED", default))
    if not (folder / "tensile").is_dir():
        pytest.skip("no published data")
    return folder
